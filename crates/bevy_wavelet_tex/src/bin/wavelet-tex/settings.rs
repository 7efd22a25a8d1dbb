//! The settings of the encoder for an image: what the command line asks for, and what the image is.

use bevy_wavelet_tex::codec::{
    image::{ColorSpace, Content},
    rate::Rate,
    settings::{EncodeSettings, GrayChannel},
};

use crate::{
    args::{AlphaArg, CutoffArg, EncodeArgs, RateArg, Role},
    error::Error,
    picture::Picture,
    plan::{RoleSource, Task},
};

/// How an image is encoded.
pub struct ImageSettings {
    pub settings: EncodeSettings,
    pub role: Option<(Role, RoleSource)>,
    /// What that does to the image.
    pub warnings: Vec<String>,
}

impl EncodeArgs {
    /// Chooses how an image is encoded.
    pub fn image_settings(&self, picture: &Picture, task: &Task) -> Result<ImageSettings, Error> {
        let mut warnings = picture.warnings.clone();
        let mut given = task.role;
        if given == Some((Role::Normal, RoleSource::Name)) && !picture.has_normals() {
            given = None;
            warnings.push(
                "its name is that of a normal map, but its pixels are no normals: it is encoded as a picture \
                 (--role normal overrides)"
                    .into(),
            );
        }
        let role = given.map(|(role, _)| role);
        let named = |content: Content| {
            let mut rates = self.rate.iter().filter_map(|rate| match rate {
                RateArg::Named(rate) => Some(*rate),
                RateArg::Bits(_) | RateArg::Auto => None,
            });
            rates.find(|rate| rate.content(false) == content)
        };
        let by_image = if picture.is_gray() {
            Content::Gray
        } else {
            Content::Color
        };
        let mut content = match (role, &self.rate[..]) {
            (Some(role), _) => role.content(),
            // A rate of another kind makes the image one of its kind.
            (None, [RateArg::Named(rate)]) => rate.content(false),
            (None, _) => by_image,
        };
        let alpha = self.keeps_alpha(picture, task, role);
        let is_gray_by_choice = role == Some(Role::Gray) || role.is_none() && content != by_image;
        let alpha = match (alpha, content) {
            (true, Content::Gray) if !is_gray_by_choice => {
                // Gray has no alpha.
                content = Content::Color;
                true
            }
            (true, Content::Gray | Content::Normal) => {
                let kind = content.name();
                warnings.push(format!(
                    "the image has transparent pixels; alpha is dropped, since {kind} has none"
                ));
                false
            }
            (alpha, _) => alpha,
        };
        let bits = self.rate.iter().find_map(|rate| match rate {
            RateArg::Bits(bits) => Some(*bits),
            RateArg::Named(_) | RateArg::Auto => None,
        });
        let with_bits =
            |bits: f64| Rate::of(content).find(|rate| rate.nominal_bits_per_pixel(false) == bits);
        let is_own_choice = matches!(given, Some((_, RoleSource::Argument)));
        let rate = match (named(content), bits, &self.rate[..]) {
            (Some(rate), _, _) => rate,
            (None, Some(bits), _) => {
                with_bits(bits).ok_or_else(|| no_such_rate(content, &bits.to_string()))?
            }
            (None, None, [RateArg::Named(rate)]) if is_own_choice => {
                return Err(no_such_rate(content, rate.name()));
            }
            (None, None, _) => Rate::usual(content),
        };
        let is_stated = picture.color_space == Some(ColorSpace::Linear)
            && !matches!(given, Some((_, RoleSource::Gltf)));
        let is_linear = self.linear
            || content == Content::Normal
            || role.is_some_and(Role::is_linear)
            || is_stated;
        let settings = EncodeSettings {
            rate,
            min_psnr_db: self.min_psnr,
            alpha,
            gray: match role {
                Some(Role::Mask) if picture.has_shape_in_alpha() => GrayChannel::Alpha,
                Some(Role::Mask | Role::Occlusion) => GrayChannel::Red,
                _ => GrayChannel::Luma,
            },
            alpha_cutoff: match (self.cutoff, role) {
                (Some(CutoffArg::None), _) => None,
                (Some(CutoffArg::At(cutoff)), _) => Some(cutoff),
                (None, Some(Role::Mask)) => Some(0.5),
                (None, _) if !alpha => None,
                (None, _) => match given {
                    Some((_, RoleSource::Gltf)) => task.cutoff,
                    _ => picture.is_cut_out().then_some(0.5),
                },
            }
            .filter(|_| alpha || role == Some(Role::Mask)),
            color_space: if is_linear {
                ColorSpace::Linear
            } else {
                ColorSpace::Srgb
            },
            mips: !self.no_mips,
            ..self.encoder.settings()
        };
        Ok(ImageSettings {
            settings,
            role: given,
            warnings,
        })
    }

    /// Whether the alpha of a picture is to be kept, as far as its content can.
    fn keeps_alpha(&self, picture: &Picture, task: &Task, role: Option<Role>) -> bool {
        let when = match self.alpha {
            AlphaArg::Auto => task.alpha,
            given => given,
        };
        when != AlphaArg::Drop && role.is_none_or(Role::has_alpha) && picture.is_transparent()
    }

    /// Returns an error when the arguments contradict each other, before any image is read.
    pub fn check(&self) -> Result<(), Error> {
        let is_auto = self.rate.contains(&RateArg::Auto);
        if is_auto && self.min_psnr.is_none() {
            return Err(Error::Usage(
                "--rate auto needs --min-psnr: set the PSNR to reach".into(),
            ));
        }
        if self.min_psnr.is_some() && self.rate.iter().any(|rate| *rate != RateArg::Auto) {
            return Err(Error::Usage(
                "--min-psnr chooses the rate: leave --rate away, or use --rate auto".into(),
            ));
        }
        let (Some(role), [one]) = (self.role, &self.rate[..]) else {
            return Ok(());
        };
        let content = role.content();
        let (fits, name) = match one {
            RateArg::Named(rate) => (rate.content(false) == content, rate.name().to_string()),
            RateArg::Bits(bits) => {
                let mut rates = Rate::of(content);
                let fits = rates.any(|rate| rate.nominal_bits_per_pixel(false) == *bits);
                (fits, bits.to_string())
            }
            RateArg::Auto => return Ok(()),
        };
        if fits {
            Ok(())
        } else {
            Err(no_such_rate(content, &name))
        }
    }
}

fn no_such_rate(content: Content, rate: &str) -> Error {
    let possible: Vec<_> = Rate::of(content).map(Rate::name).collect();
    Error::Usage(format!(
        "{} cannot be coded at {rate} bits per pixel; possible are {}",
        content.name(),
        possible.join(", "),
    ))
}
