//! What is drawn, by the names in the rows.

/// What is drawn, and how. A camera is `Hdr`, without multisampling, unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// A texture of the base colour.
    BaseColor,
    /// Textures of the base colour and of normals.
    NormalMapped,
    /// The five maps of a glTF material.
    FiveMaps,
    /// A texture of the base colour, parts of which are cut out, with prepasses of depth, normals and motion.
    Masked,
    /// The five maps, drawn deferred.
    Deferred,
    /// The base colour with four samples a pixel.
    Multisampled,
    /// The base colour in a camera without `Hdr`.
    EightBits,
}

impl Scene {
    /// The scenes in which materials differ.
    pub const MATERIALS: [Self; 4] = [
        Self::BaseColor,
        Self::FiveMaps,
        Self::Masked,
        Self::Deferred,
    ];
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::BaseColor,
        Self::NormalMapped,
        Self::FiveMaps,
        Self::Masked,
        Self::Deferred,
        Self::Multisampled,
        Self::EightBits,
    ];

    /// Its name in the rows.
    pub const fn material(self) -> &'static str {
        match self {
            Self::BaseColor => "base color",
            Self::NormalMapped => "base color, normals",
            Self::FiveMaps => "five maps",
            Self::Masked => "alpha mask",
            Self::Deferred => "five maps, deferred",
            Self::Multisampled => "base color, 4 samples",
            Self::EightBits => "base color, 8 bits",
        }
    }

    /// Whether the material has the five maps of glTF.
    pub fn has_five_maps(self) -> bool {
        matches!(self, Self::FiveMaps | Self::Deferred)
    }
}
