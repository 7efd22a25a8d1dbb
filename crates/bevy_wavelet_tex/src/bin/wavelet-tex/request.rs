//! What the command line asks of the encoder for one image.

use bevy_wavelet_tex::codec::{
    image::{ColorSpace, Content},
    rate::Rate,
};

use crate::{
    args::EncoderOptions,
    choices::{RateArg, Role},
    error::Error,
};

/// The resolved request for one image.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    pub rate: Rate,
    pub min_psnr_db: Option<f64>,
    pub linear: bool,
}

impl Request {
    pub fn color_space(self) -> ColorSpace {
        if self.linear {
            ColorSpace::Linear
        } else {
            ColorSpace::Srgb
        }
    }
}

impl EncoderOptions {
    /// Resolves the arguments for an image. `role` overrides the role on the command line.
    pub fn request(&self, image_is_gray: bool, role: Option<Role>) -> Result<Request, Error> {
        let role = role.or(self.role);
        let by_rate = match self.rate {
            Some(RateArg::Named(rate)) => Some(rate.content(false)),
            Some(RateArg::Bits(4.0)) => Some(Content::Normal),
            Some(RateArg::Bits(2.0)) => Some(Content::Gray),
            Some(RateArg::Bits(3.0)) if image_is_gray => Some(Content::Gray),
            Some(RateArg::Bits(_)) => Some(Content::Color),
            Some(RateArg::Auto) | None => None,
        };
        let content = match role {
            Some(role) => role.content(),
            None => by_rate.unwrap_or(if image_is_gray {
                Content::Gray
            } else {
                Content::Color
            }),
        };
        let rate = match self.rate {
            Some(RateArg::Named(rate)) if rate.content(false) == content => rate,
            Some(RateArg::Bits(bits)) => Rate::of(content)
                .find(|rate| rate.nominal_bits_per_pixel(false) == bits)
                .ok_or_else(|| self.no_such_rate(content))?,
            Some(RateArg::Named(_)) => return Err(self.no_such_rate(content)),
            Some(RateArg::Auto) | None => Rate::usual(content),
        };
        Ok(Request {
            rate,
            min_psnr_db: self.min_psnr,
            linear: self.linear
                || content == Content::Normal
                || matches!(role, Some(Role::Mask | Role::Data)),
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
                Some(role) => self.request(false, Some(role)).map(|_| ()),
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
