//! The textures of a material that change how its surface is lit, whatever it is made of.

use glam::{Vec3, Vec4};

use super::map::Map;

/// The textures of a material that most materials have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Colours, by which the material's own is multiplied.
    pub color: Option<Map>,
    /// Bumps.
    pub normal: Option<NormalMap>,
    /// Holes.
    pub opacity: Option<OpacityMap>,
}

impl Maps {
    /// No textures.
    pub const NONE: &Self = &Self { color: None, normal: None, opacity: None };

    /// A few words for people, to follow others.
    pub fn describe(&self) -> &'static str {
        match (self.color.is_some(), self.normal.is_some(), self.opacity.is_some()) {
            (false, false, false) => "",
            (_, false, false) => ", textured",
            (_, true, false) => ", textured, with bumps",
            (_, false, true) => ", textured, with holes",
            (_, true, true) => ", textured, with bumps and holes",
        }
    }
}

/// Normals relative to the surface: of a texel, red is along the texture's width, green along its height, blue away from the surface, each
/// from -1 for 0 to 1 for 1.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// The normals.
    pub map: Map,
    /// By how much they are tilted further.
    pub scale: f32,
}

impl NormalMap {
    /// The normal of a texel, of any length; straight up where it points into the surface.
    #[inline]
    pub fn normal(&self, texel: Vec4) -> Vec3 {
        let n = texel.truncate() * 2.0 - Vec3::ONE;
        if n.z > 0.0 { Vec3::new(n.x * self.scale, n.y * self.scale, n.z) } else { Vec3::Z }
    }
}

/// One number of each texel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelMap {
    /// The texels.
    pub map: Map,
    /// Which number of a texel counts, from red (0) to alpha (3).
    pub channel: usize,
}

/// How much of the light a surface stops, as a texture says.
#[derive(Clone, Debug, PartialEq)]
pub struct OpacityMap {
    /// The opacities.
    pub map: Map,
    /// Which number of a texel counts: red (0) or alpha (3).
    pub channel: usize,
    /// They are multiplied by this.
    pub factor: f32,
    /// What is at least as opaque is opaque, all else is not there.
    pub cutoff: Option<f32>,
}

impl OpacityMap {
    /// The opacity of a texel, 0 to 1.
    #[inline]
    pub fn opacity(&self, texel: Vec4) -> f32 {
        let opacity = (texel[self.channel] * self.factor).clamp(0.0, 1.0);
        match self.cutoff {
            Some(cutoff) if opacity >= cutoff => 1.0,
            Some(_) => 0.0,
            None => opacity,
        }
    }
}
