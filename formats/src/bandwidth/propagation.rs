//! How fast reflected light varies in a rendering: propagation of local bandwidth from a light to a pixel, and the
//! sampling rates that follow. Rules in words: `formats/src/bandwidth/propagation.md`.
//!
//! After Bagher, Soler, Subr, Belcour and Holzschuch 2012, "Interactive rendering of acquired materials on dynamic
//! geometry using bandwidth prediction", sections
//! 2.1 to 2.3 and figure 5; equation numbers are theirs. Signs of shears are dropped, so that every result is an upper
//! bound. [`PROPAGATION_WGSL`] has the same functions with the same steps: the bits are equal where additions,
//! multiplications, divisions and square roots are rounded correctly and not fused.
//!
//! Every number that goes in is finite and not negative; every number that comes out is, too.

/// The same functions in WGSL, without bindings.
pub const PROPAGATION_WGSL: &str = include_str!("propagation.wgsl");

/// What stands for light or material without a limit, and the largest value that any operator gives: cycles per metre or
/// per radian. Finer than the wavelength of light.
pub const UNLIMITED: f32 = 1e9;

/// Cosines to the normal below this count as this: a surface seen edge-on has no end of frequencies.
pub const SMALLEST_COSINE: f32 = 0.0009765625;

/// How fast the albedo of a material that is not matte varies with the viewer's angle, cycles per radian, roughly: it rises
/// towards grazing angles over about a radian.
pub const ALBEDO: f32 = 0.5;

/// Contributions and their means below this are black, and need no samples.
const BLACK: f32 = 1e-18;
/// Largest contribution, so that its square stays finite.
pub const BRIGHTEST: f32 = 1e12;

/// Local bandwidth around a ray: `v = (v_s, v_a)` of section 2.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bandwidth {
    /// Variation across the ray, cycles per metre.
    pub spatial: f32,
    /// Variation over direction, cycles per radian.
    pub angular: f32,
}

impl Bandwidth {
    /// Light from far away varies with direction alone.
    pub fn distant(angular: f32) -> Self {
        Self { spatial: 0.0, angular }
    }

    /// `T_d`: free flight over `distance` metres, `v_a += d v_s`.
    pub fn flight(self, distance: f32) -> Self {
        Self { angular: limited(self.angular + distance * self.spatial), ..self }
    }

    /// `P_i`: from across the ray to along the surface, `v_s *= cos θi`.
    pub fn into_surface(self, cos_incoming: f32) -> Self {
        Self { spatial: limited(self.spatial * cos_incoming), ..self }
    }

    /// `C_c`, and `C_-c` without its sign: the normals of a surface of this curvature (1/m) turn what varies with
    /// direction into what varies along the surface, `v_s += c v_a`.
    pub fn curvature(self, curvature: f32) -> Self {
        Self { spatial: limited(self.spatial + curvature * self.angular), ..self }
    }

    /// `B_t,ρ`: a material lets through what varies no faster than its lobe, and its texture adds its own variation:
    /// `v_a = min(v_a, ρ)`, `v_s += t`.
    pub fn reflection(self, lobe: f32, texture: f32) -> Self {
        Self { spatial: limited(self.spatial + texture), angular: limited(self.angular.min(lobe)) }
    }

    /// `P_o`: from along the surface to across the ray, `v_s /= cos θo`.
    pub fn out_of_surface(self, cos_outgoing: f32) -> Self {
        Self { spatial: limited(self.spatial / cos_outgoing.max(SMALLEST_COSINE)), ..self }
    }

    /// `R`, equation 3: from the ray that arrives to the ray that leaves.
    pub fn reflected(self, surface: BandwidthSurface) -> Self {
        self.into_surface(surface.cos_incoming)
            .curvature(surface.curvature)
            .reflection(surface.lobe, surface.texture)
            .curvature(surface.curvature)
            .out_of_surface(surface.cos_outgoing)
    }

    /// Equation 4: from the light to the image plane, over one reflection. `light_distance` and `image_distance`, `d` and
    /// `d'`, are in metres. Of light from far away the spatial bandwidth is 0, so that its distance does not matter:
    /// give 0.
    pub fn one_bounce(self, light_distance: f32, surface: BandwidthSurface, image_distance: f32) -> Self {
        self.flight(light_distance).reflected(surface).flight(image_distance)
    }
}

/// What reflects a ray: the parameters of [`Bandwidth::reflected`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandwidthSurface {
    /// Cosine of the incoming direction to the normal, 0 to 1.
    pub cos_incoming: f32,
    /// Cosine of the outgoing direction to the normal, 0 to 1; see [`SMALLEST_COSINE`].
    pub cos_outgoing: f32,
    /// `c`, the larger principal curvature without its sign, 1/m; 0 is flat.
    pub curvature: f32,
    /// `ρ`, angular bandwidth of the lobe in these directions, cycles per radian.
    pub lobe: f32,
    /// `t`, bandwidth of the texture along the surface, cycles per metre; 0 without one.
    pub texture: f32,
}

impl BandwidthSurface {
    /// What the surface shows in light that does not vary: its albedo changes with the viewer's angle, [`ALBEDO`] or as fast as
    /// the lobe if that is less. From the surface to the image plane, as [`Bandwidth::one_bounce`]; not in the paper.
    pub fn albedo(self, image_distance: f32) -> Bandwidth {
        let own = Bandwidth::distant(self.lobe.min(ALBEDO));
        own.curvature(self.curvature).out_of_surface(self.cos_outgoing).flight(image_distance)
    }
}

/// Equation 5: the mean bandwidth at a pixel over a few incident directions, weighted by what each brings.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BandwidthAverage {
    weighted: Bandwidth,
    weight: f32,
}

impl BandwidthAverage {
    /// Adds the bandwidth of one direction. The weight is the luminance of `L ρ cos θi`, divided by the density that the
    /// direction was drawn with.
    pub fn add(self, bandwidth: Bandwidth, weight: f32) -> Self {
        let weight = weight.min(BRIGHTEST);
        Self {
            weighted: Bandwidth {
                spatial: self.weighted.spatial + weight * bandwidth.spatial,
                angular: self.weighted.angular + weight * bandwidth.angular,
            },
            weight: self.weight + weight,
        }
    }

    /// With the directions of another part of the sum.
    pub fn join(self, other: Self) -> Self {
        Self {
            weighted: Bandwidth {
                spatial: self.weighted.spatial + other.weighted.spatial,
                angular: self.weighted.angular + other.weighted.angular,
            },
            weight: self.weight + other.weight,
        }
    }

    /// The mean; 0 where all is black.
    pub fn mean(self) -> Bandwidth {
        if self.weight < BLACK {
            return Bandwidth::default();
        }
        Bandwidth {
            spatial: limited(self.weighted.spatial / self.weight),
            angular: limited(self.weighted.angular / self.weight),
        }
    }
}

/// Equation 6: bandwidth at a pixel in cycles per pixel, `b = v_a max(f_x / W, f_y / H)`.
///
/// `angular` in cycles per radian; `field_of_view` in radians and `size` in pixels, both across and down; `largest` from
/// [`largest_pixel_bandwidth`].
pub fn pixel_bandwidth(angular: f32, field_of_view: [f32; 2], size: [f32; 2], largest: f32) -> f32 {
    let pixel = (field_of_view[0] / size[0]).max(field_of_view[1] / size[1]);
    (angular * pixel).min(largest)
}

/// What pixels can show: half a cycle per pixel, and twice as much for each level of antialiasing, 1 for 2 x 2 and 2 for
/// 4 x 4 samples per pixel. Up to 16 levels.
pub fn largest_pixel_bandwidth(antialiasing_levels: u32) -> f32 {
    0.5 * (1u32 << antialiasing_levels.min(16)) as f32
}

/// Equation 8, counted from the finest: level `l` shades every `2^l`-th pixel along each axis, often enough for
/// `bandwidth` cycles per pixel by Nyquist: `min(⌊log2(1 / 2b)⌋, coarsest)`. `coarsest` is 0 to 100.
///
/// Negative levels shade `4^-l` samples per pixel. A bandwidth of 0 gives `coarsest`.
pub fn pyramid_level(bandwidth: f32, coarsest: i32) -> i32 {
    // ⌊-log2 x⌋ = -⌈log2 x⌉, and the bits of x have ⌊log2 x⌋ and whether x is a power of two.
    let bits = (2.0 * bandwidth).to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let beyond = i32::from(bits & 0x7f_ffff != 0);
    (-(exponent + beyond)).min(coarsest)
}

/// Light from a range of directions, as a few numbers that sums over directions need.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DirectedLight {
    /// `L̄`, mean radiance (luminance), at most [`BRIGHTEST`].
    pub radiance: f32,
    /// Mean of `ν_i L_i` over `L̄`, cycles per radian: bandwidth weighted by light.
    pub bandwidth: f32,
    /// Mean of `L_i²`.
    pub squares: f32,
    /// Mean of `ν_i L_i²`.
    pub varying: f32,
}

impl DirectedLight {
    /// Of directions with one bandwidth: means of radiance and of its square, of at most [`BRIGHTEST`].
    pub fn of(radiance: f32, squares: f32, bandwidth: f32) -> Self {
        let bandwidth = limited(bandwidth);
        Self { radiance, bandwidth, squares, varying: bandwidth * squares }
    }

    /// Means of `L`, `ν L`, `L²` and `ν L²`, which may be averaged over directions.
    pub fn moments(self) -> [f32; 4] {
        [self.radiance, self.bandwidth * self.radiance, self.squares, self.varying]
    }

    /// Of averaged [`Self::moments`].
    pub fn from_moments([radiance, weighted, squares, varying]: [f32; 4]) -> Self {
        let bandwidth = if radiance < BLACK { 0.0 } else { limited(weighted / radiance) };
        Self { radiance, bandwidth, squares, varying }
    }
}

/// Equation 7: how much the estimate of a pixel's radiance varies from sample to sample, from a few incident directions.
///
/// The paper bounds the variance about a direction by `(ν_i + ν_ρ) X_i²`, with `X_i = L ρ cos θi`, and then prints the
/// sum of `(ν_i + ν_ρ) X_i`. We sum the bound as derived, with the square, and divide by the squared mean:
///
/// `V = 1/n Σ (ν_i + ν_ρ) X_i² / max(1/n Σ X_i, darkest)²`
///
/// With the square, a few bright directions among dark ones count for more than the same light spread evenly, as they do
/// in the variance; and `V` does not change when lights are dimmed or the exposure is changed. `N` samples have a
/// variance of about `V / N` relative to the squared mean, so `N` in proportion to `V` gives every pixel the same
/// relative error. Where errors below some radiance do not matter, as on a display, give it as `darkest`: below it the
/// error is equal in absolute terms. It is an upper bound of unknown tightness, in cycles per radian: the factor from
/// `V` to `N` is to be chosen, see [`sample_scale`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VarianceEstimate {
    squares: f32,
    sum: f32,
    directions: f32,
}

impl VarianceEstimate {
    /// Adds one direction: angular bandwidths `ν_i` of the light that arrives and `ν_ρ` of the lobe, cycles per radian,
    /// and the luminance of `L ρ cos θi` divided by the density that the direction was drawn with.
    pub fn add(self, light: f32, lobe: f32, contribution: f32) -> Self {
        let contribution = contribution.min(BRIGHTEST);
        let bandwidth = limited(light + lobe);
        Self {
            squares: self.squares + bandwidth * (contribution * contribution),
            sum: self.sum + contribution,
            directions: self.directions + 1.0,
        }
    }

    /// Adds a range of directions that one stands for; of each, `L` is proportional to the contribution, as it is where
    /// directions are drawn in proportion to the lobe.
    pub fn add_range(self, light: DirectedLight, lobe: f32) -> Self {
        Self {
            squares: self.squares + light.varying + limited(lobe) * light.squares,
            sum: self.sum + light.radiance,
            directions: self.directions + 1.0,
        }
    }

    /// With the directions of another part of the sum.
    pub fn join(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            sum: self.sum + other.sum,
            directions: self.directions + other.directions,
        }
    }

    /// The mean contribution.
    pub fn mean(self) -> f32 {
        self.sum / self.directions.max(1.0)
    }

    /// `V`; 0 where all is black. `darkest` is a radiance, 0 for relative errors everywhere.
    pub fn relative(self, darkest: f32) -> f32 {
        let directions = self.directions.max(1.0);
        let mean = self.mean().max(darkest);
        if mean < BLACK {
            return 0.0;
        }
        limited(self.squares / directions / mean / mean)
    }
}

/// The factor from `demand` to samples that spends `samples` per shaded pixel where the mean of `demand` over them is
/// `mean_demand`, before [`sample_count`] holds them to its range. 0 where nothing varies.
pub fn sample_scale(mean_demand: f32, samples: f32) -> f32 {
    if mean_demand > 0.0 { limited(samples / mean_demand) } else { 0.0 }
}

/// Samples of a shaded pixel (equation 7): `scale demand`, rounded up, in the range `fewest..=most`. `most` is at most 2^24.
///
/// `demand` is `V` for the same relative error everywhere, as in the paper; its root, weighed by how errors show, for the
/// least squared error of a rendering (`propagation.md`, step 6).
pub fn sample_count(demand: f32, scale: f32, fewest: u32, most: u32) -> u32 {
    let wanted = limited(scale * demand).ceil();
    wanted.max(fewest as f32).min(most as f32) as u32
}

fn limited(value: f32) -> f32 {
    value.min(UNLIMITED)
}

#[cfg(test)]
mod tests;
