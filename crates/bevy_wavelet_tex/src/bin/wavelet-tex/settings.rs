//! The settings of the encoder for an image: what the command line asks for, what the image is, and what its name says.

use std::path::Path;

use bevy_wavelet_tex::codec::{
    image::{ColorSpace, Content},
    rate::Rate,
    settings::{EncodeSettings, GrayChannel},
};
use clap::ValueEnum;
use glob::Pattern;

use crate::{
    Error,
    args::{AlphaArg, CutoffArg, EncodeArgs, RateArg, Role},
    files,
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
        let is_own_choice = matches!(given, Some((_, RoleSource::Argument)));
        let rate = match (named(content), bits, &self.rate[..]) {
            (Some(rate), _, _) => rate,
            (None, Some(bits), _) => {
                with_bits(content, bits).ok_or_else(|| no_such_rate(content, &bits.to_string()))?
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
            RateArg::Bits(bits) => (with_bits(content, *bits).is_some(), bits.to_string()),
            RateArg::Auto => return Ok(()),
        };
        match fits {
            true => Ok(()),
            false => Err(no_such_rate(content, &name)),
        }
    }
}

/// The rate of a content with so many bits per pixel.
fn with_bits(content: Content, bits: f64) -> Option<Rate> {
    Rate::of(content).find(|rate| rate.nominal_bits_per_pixel(false) == bits)
}

fn no_such_rate(content: Content, rate: &str) -> Error {
    let possible: Vec<_> = Rate::of(content).map(Rate::name).collect();
    Error::Usage(format!(
        "{} cannot be coded at {rate} bits per pixel; possible are {}",
        content.name(),
        possible.join(", "),
    ))
}

/// Ends of file names, and the roles that they stand for.
const ENDS: [(Role, &str); 5] = [
    (Role::Normal, "n nrm nor norm normal normals normalmap"),
    (
        Role::Data,
        "orm arm rma mra metallicroughness metalroughness metalrough occlusionroughnessmetallic roughnessmetallic",
    ),
    (
        Role::Occlusion,
        "ao occ occlusion ambientocclusion rough roughness metal metallic metalness height disp displacement",
    ),
    (Role::Mask, "opacity cutout"),
    (
        Role::Color,
        "albedo basecolor basecolour color colour diff diffuse emissive emission",
    ),
];

/// Ends that say nothing of the role: whose Y a normal map has, and the size.
const IGNORED: [&str; 10] = [
    "gl", "dx", "opengl", "directx", "1k", "2k", "4k", "8k", "16k", "512",
];

/// The patterns of a file, each with a role, which come before the ends of names.
#[derive(Default)]
pub struct Patterns(Vec<(Pattern, Role)>);

impl Patterns {
    /// Reads lines of a pattern and a role. Lines that begin with # are comments.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        let text = String::from_utf8_lossy(&bytes);
        let mut patterns = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let fail =
                |problem: String| Error::file(path, format_args!("line {}: {problem}", number + 1));
            let (pattern, role) = line
                .rsplit_once(char::is_whitespace)
                .ok_or_else(|| fail("a pattern and a role are needed".into()))?;
            let pattern = Pattern::new(pattern.trim()).map_err(|e| fail(e.to_string()))?;
            let role = Role::from_str(role, true).map_err(|_| {
                let roles = Role::value_variants().iter().map(|role| role.name());
                let roles = roles.collect::<Vec<_>>().join(", ");
                fail(format!("{role} is no role: possible are {roles}"))
            })?;
            patterns.push((pattern, role));
        }
        Ok(Self(patterns))
    }

    /// The role of a file, by its path below the argument, its name, or its name without the extension.
    pub fn role(&self, relative: &Path) -> Option<Role> {
        let name = relative.file_name().unwrap_or_default().to_string_lossy();
        let stem = relative.file_stem().unwrap_or_default().to_string_lossy();
        let fits = |(pattern, _): &&(Pattern, Role)| {
            pattern.matches_path(relative) || pattern.matches(&name) || pattern.matches(&stem)
        };
        let given = self.0.iter().find(fits).map(|(_, role)| *role);
        given.or_else(|| by_end(&stem))
    }
}

/// The role that the last word of a name stands for, which is not its only one.
fn by_end(stem: &str) -> Option<Role> {
    let lower = stem.to_ascii_lowercase();
    let mut words = lower.split(['_', '-', '.', ' ']).collect::<Vec<_>>();
    while words.len() > 2 && words.last().is_some_and(|word| IGNORED.contains(word)) {
        words.pop();
    }
    let [_, .., last] = words.as_slice() else {
        return None;
    };
    let mut all = ENDS.iter();
    all.find(|(_, ends)| ends.split(' ').any(|end| end == *last))
        .map(|(role, _)| *role)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_texture_sites_tell_their_role() {
        for (name, role) in [
            ("wall_n", Some(Role::Normal)),
            ("Wall_Normal", Some(Role::Normal)),
            ("rock_nor_gl_4k", Some(Role::Normal)),
            ("wall_orm", Some(Role::Data)),
            ("Default_metalRoughness", Some(Role::Data)),
            ("wall-ao", Some(Role::Occlusion)),
            ("leaf_opacity", Some(Role::Mask)),
            ("Wall_BaseColor", Some(Role::Color)),
            ("n", None),
            ("normal", None),
            ("canyon", None),
            ("photo_1", None),
        ] {
            assert_eq!(by_end(name), role, "{name}");
        }
    }
}
