//! The settings of the encoder that the command line asks for.

use bevy_wavelet_tex::codec::{
    image::{ColorSpace, Content},
    rate::Rate,
    settings::EncodeSettings,
};

use crate::{
    args::EncodeArgs,
    choices::{RateArg, Role},
    error::Error,
};

impl EncodeArgs {
    /// Returns the settings for an image. `role` overrides the role on the command line.
    pub fn settings(
        &self,
        image_is_gray: bool,
        role: Option<Role>,
    ) -> Result<EncodeSettings, Error> {
        let role = role.or(self.role);
        let by_rate = match self.rate {
            Some(RateArg::Named(rate)) => Some(rate.content(false)),
            Some(RateArg::Bits(4.0)) => Some(Content::Normal),
            Some(RateArg::Bits(2.0)) => Some(Content::Gray),
            Some(RateArg::Bits(3.0)) if image_is_gray => Some(Content::Gray),
            Some(RateArg::Bits(_)) => Some(Content::Color),
            Some(RateArg::Auto) | None => None,
        };
        let by_image = if image_is_gray {
            Content::Gray
        } else {
            Content::Color
        };
        let content = role.map(Role::content).or(by_rate).unwrap_or(by_image);
        let rate = match self.rate {
            Some(RateArg::Named(rate)) if rate.content(false) == content => rate,
            Some(RateArg::Bits(bits)) => Rate::of(content)
                .find(|rate| rate.nominal_bits_per_pixel(false) == bits)
                .ok_or_else(|| self.no_such_rate(content))?,
            Some(RateArg::Named(_)) => return Err(self.no_such_rate(content)),
            Some(RateArg::Auto) | None => Rate::usual(content),
        };
        let is_linear = self.linear
            || content == Content::Normal
            || matches!(role, Some(Role::Mask | Role::Data));
        Ok(EncodeSettings {
            rate,
            min_psnr_db: self.min_psnr,
            alpha: self.alpha,
            color_space: if is_linear {
                ColorSpace::Linear
            } else {
                ColorSpace::Srgb
            },
            mips: !self.no_mips,
            ..self.encoder.settings()
        })
    }

    /// Returns an error when the arguments contradict each other, before any image is read.
    pub fn check(&self) -> Result<(), Error> {
        match (self.rate, self.min_psnr) {
            (Some(RateArg::Auto), None) => Err(Error::Usage(
                "--rate auto needs --min-psnr: set the PSNR to reach".into(),
            )),
            (Some(RateArg::Named(_) | RateArg::Bits(_)), Some(_)) => Err(Error::Usage(
                "--min-psnr chooses the rate: leave --rate away, or use --rate auto".into(),
            )),
            _ => match self.role {
                Some(role) => self.settings(false, Some(role)).map(|_| ()),
                None => Ok(()),
            },
        }
    }

    fn no_such_rate(&self, content: Content) -> Error {
        let rate = match self.rate {
            Some(RateArg::Named(rate)) => rate.name().to_string(),
            Some(RateArg::Bits(bits)) => bits.to_string(),
            Some(RateArg::Auto) | None => "auto".into(),
        };
        let possible: Vec<_> = Rate::of(content).map(Rate::name).collect();
        Error::Usage(format!(
            "{} cannot be coded at {rate} bits per pixel; possible are {}",
            content.name(),
            possible.join(", "),
        ))
    }
}
