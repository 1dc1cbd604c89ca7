//! Propagation of local bandwidth from a light to a pixel, and the sampling rates that follow. Equations:
//! `formats/src/bandwidth/propagation.md`.
//!
//! Implements sections 2.1 to 2.3 and figure 5 of Bagher, Soler, Subr, Belcour and Holzschuch 2012, "Interactive
//! rendering of acquired materials on dynamic geometry using bandwidth prediction"; equation numbers refer to that
//! paper. Signs of shears are dropped, so that every result is an upper bound. [`PROPAGATION_WGSL`] has the same
//! functions with the same steps; results have the same bits if additions, multiplications, divisions and square roots
//! are correctly rounded and not fused.
//!
//! All inputs must be finite and non-negative; all outputs are.

/// Same functions in WGSL, without bindings.
pub const PROPAGATION_WGSL: &str = include_str!("propagation.wgsl");

/// Value for light or material with unlimited bandwidth, and the maximum result of all operators: cycles per metre or
/// per radian. Its period is shorter than the wavelength of light.
pub const UNLIMITED: f32 = 1e9;

/// Minimum cosine to the normal; smaller cosines are clamped to it, because bandwidth diverges at grazing angles.
pub const SMALLEST_COSINE: f32 = 0.0009765625;

/// Approximate bandwidth of the albedo of a glossy material over the viewer's angle, cycles per radian: it rises
/// towards grazing angles over about a radian.
pub const ALBEDO: f32 = 0.5;

/// Contributions and means below this count as black and need no samples.
const BLACK: f32 = 1e-18;
/// Maximum contribution, whose square is finite.
pub const BRIGHTEST: f32 = 1e12;

/// Local bandwidth around a ray: `v = (v_s, v_a)` of section 2.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bandwidth {
    /// Bandwidth across the ray, cycles per metre.
    pub spatial: f32,
    /// Bandwidth over direction, cycles per radian.
    pub angular: f32,
}

impl Bandwidth {
    /// Bandwidth of distant light, which varies only with direction.
    pub fn distant(angular: f32) -> Self {
        Self { spatial: 0.0, angular }
    }

    /// `T_d`: free flight over `distance` metres, `v_a += d v_s`.
    pub fn flight(self, distance: f32) -> Self {
        Self { angular: limited(self.angular + distance * self.spatial), ..self }
    }

    /// `P_i`: projection from across the ray onto the surface, `v_s *= cos θi`.
    pub fn into_surface(self, cos_incoming: f32) -> Self {
        Self { spatial: limited(self.spatial * cos_incoming), ..self }
    }

    /// `C_c`, and `C_-c` without its sign: the normals of a surface with this curvature (1/m) convert angular to
    /// spatial variation, `v_s += c v_a`.
    pub fn curvature(self, curvature: f32) -> Self {
        Self { spatial: limited(self.spatial + curvature * self.angular), ..self }
    }

    /// `B_t,ρ`: a material limits angular bandwidth to the bandwidth of its lobe, and its texture adds spatial
    /// bandwidth: `v_a = min(v_a, ρ)`, `v_s += t`.
    pub fn reflection(self, lobe: f32, texture: f32) -> Self {
        Self { spatial: limited(self.spatial + texture), angular: limited(self.angular.min(lobe)) }
    }

    /// `P_o`: projection from the surface to across the ray, `v_s /= cos θo`.
    pub fn out_of_surface(self, cos_outgoing: f32) -> Self {
        Self { spatial: limited(self.spatial / cos_outgoing.max(SMALLEST_COSINE)), ..self }
    }

    /// `R`, equation 3: from the incoming to the outgoing ray.
    pub fn reflected(self, surface: BandwidthSurface) -> Self {
        self.into_surface(surface.cos_incoming)
            .curvature(surface.curvature)
            .reflection(surface.lobe, surface.texture)
            .curvature(surface.curvature)
            .out_of_surface(surface.cos_outgoing)
    }

    /// Equation 4: from the light to the image plane over one reflection. `light_distance` and `image_distance`, `d`
    /// and `d'`, are in metres. For distant light the spatial bandwidth is 0 and `light_distance` has no effect: pass
    /// 0.
    pub fn one_bounce(self, light_distance: f32, surface: BandwidthSurface, image_distance: f32) -> Self {
        self.flight(light_distance).reflected(surface).flight(image_distance)
    }
}

/// Surface that reflects a ray: the parameters of [`Bandwidth::reflected`].
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
    /// `t`, bandwidth of the texture along the surface, cycles per metre; 0 without a texture.
    pub texture: f32,
}

impl BandwidthSurface {
    /// Bandwidth of the surface in constant light, at the image plane. The albedo varies with the viewer's angle, at
    /// [`ALBEDO`] or the bandwidth of the lobe, whichever is lower. Propagated as in [`Bandwidth::one_bounce`]; not in
    /// the paper.
    pub fn albedo(self, image_distance: f32) -> Bandwidth {
        let own = Bandwidth::distant(self.lobe.min(ALBEDO));
        own.curvature(self.curvature).out_of_surface(self.cos_outgoing).flight(image_distance)
    }
}

/// Equation 5: mean bandwidth at a pixel over a few incident directions, weighted by their contributions.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BandwidthAverage {
    weighted: Bandwidth,
    weight: f32,
}

impl BandwidthAverage {
    /// Adds the bandwidth of one direction. The weight is the luminance of `L f_r cos θi`, divided by the sampling
    /// density of the direction.
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

    /// Merges two partial sums.
    pub fn join(self, other: Self) -> Self {
        Self {
            weighted: Bandwidth {
                spatial: self.weighted.spatial + other.weighted.spatial,
                angular: self.weighted.angular + other.weighted.angular,
            },
            weight: self.weight + other.weight,
        }
    }

    /// Mean bandwidth; 0 if all contributions are black.
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
/// `angular` is in cycles per radian; `field_of_view` in radians and `size` in pixels, both horizontal and vertical;
/// `largest` comes from [`largest_pixel_bandwidth`].
pub fn pixel_bandwidth(angular: f32, field_of_view: [f32; 2], size: [f32; 2], largest: f32) -> f32 {
    let pixel = (field_of_view[0] / size[0]).max(field_of_view[1] / size[1]);
    (angular * pixel).min(largest)
}

/// Maximum bandwidth that pixels resolve: half a cycle per pixel, doubled for each level of antialiasing, 1 for 2 x 2
/// and 2 for 4 x 4 samples per pixel. Up to 16 levels.
pub fn largest_pixel_bandwidth(antialiasing_levels: u32) -> f32 {
    0.5 * (1u32 << antialiasing_levels.min(16)) as f32
}

/// Equation 8, counted from the finest level. Level `l` shades every `2^l`-th pixel along each axis, the coarsest rate
/// that satisfies Nyquist for `bandwidth` cycles per pixel: `min(⌊log2(1 / 2b)⌋, coarsest)`. `coarsest` is 0 to 100.
///
/// Negative levels shade `4^-l` samples per pixel. A bandwidth of 0 gives `coarsest`.
pub fn pyramid_level(bandwidth: f32, coarsest: i32) -> i32 {
    // ⌊-log2 x⌋ = -⌈log2 x⌉; the bits of x give ⌊log2 x⌋ and whether x is a power of two.
    let bits = (2.0 * bandwidth).to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let beyond = i32::from(bits & 0x7f_ffff != 0);
    (-(exponent + beyond)).min(coarsest)
}

/// Light from a range of directions, as the moments that sums over directions need.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DirectedLight {
    /// `L̄`, mean radiance (luminance), at most [`BRIGHTEST`].
    pub radiance: f32,
    /// Mean of `ν_i L_i` over `L̄`, cycles per radian: light-weighted bandwidth.
    pub bandwidth: f32,
    /// Mean of `L_i²`, for the spread of radiance between directions.
    pub squares: f32,
    /// Mean of `ν_i L_i²`.
    pub varying: f32,
}

impl DirectedLight {
    /// Light of directions with one bandwidth: means of radiance and of its square, of at most [`BRIGHTEST`].
    pub fn of(radiance: f32, squares: f32, bandwidth: f32) -> Self {
        let bandwidth = limited(bandwidth);
        Self { radiance, bandwidth, squares, varying: bandwidth * squares }
    }

    /// Means of `L`, `ν L`, `L²` and `ν L²`, which can be averaged over directions.
    pub fn moments(self) -> [f32; 4] {
        [self.radiance, self.bandwidth * self.radiance, self.squares, self.varying]
    }

    /// Inverse of [`Self::moments`], for averages.
    pub fn from_moments([radiance, weighted, squares, varying]: [f32; 4]) -> Self {
        let bandwidth = if radiance < BLACK { 0.0 } else { limited(weighted / radiance) };
        Self { radiance, bandwidth, squares, varying }
    }
}

/// Equation 7: variance of the estimate of a pixel's radiance between samples, from a few incident directions.
///
/// The paper bounds the variance about a direction by `(ν_i + ν_ρ) X_i²`, with `X_i = L f_r cos θi`, and then prints
/// the sum of `(ν_i + ν_ρ) X_i`. This implementation sums the derived bound, with the square, and divides by the
/// squared mean:
///
/// `V = 1/n Σ (ν_i + ν_ρ) X_i² / max(1/n Σ X_i, darkest)²`
///
/// With the square, a few bright directions among dark ones count for more than the same light spread evenly, as in the
/// variance, and `V` does not change with exposure. `N` samples have a relative variance of about `V / N`, so `N` in
/// proportion to `V` gives all pixels the same relative error. `darkest` is the radiance below which the error is
/// absolute rather than relative, for example on a display. `V` is an upper bound of unknown tightness, in cycles per
/// radian; the factor from `V` to `N` is a parameter, see [`sample_scale`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VarianceEstimate {
    squares: f32,
    sum: f32,
    directions: f32,
}

impl VarianceEstimate {
    /// Adds one direction: angular bandwidths `ν_i` of the incoming light and `ν_ρ` of the lobe, cycles per radian, and
    /// the luminance of `L f_r cos θi` divided by the sampling density of the direction.
    pub fn add(self, light: f32, lobe: f32, contribution: f32) -> Self {
        let contribution = contribution.min(BRIGHTEST);
        let bandwidth = limited(light + lobe);
        Self {
            squares: self.squares + bandwidth * (contribution * contribution),
            sum: self.sum + contribution,
            directions: self.directions + 1.0,
        }
    }

    /// Adds a range of directions represented by one. `L` is proportional to the contribution of each, as it is for
    /// directions drawn in proportion to the lobe.
    pub fn add_range(self, light: DirectedLight, lobe: f32) -> Self {
        Self {
            squares: self.squares + light.varying + limited(lobe) * light.squares,
            sum: self.sum + light.radiance,
            directions: self.directions + 1.0,
        }
    }

    /// Merges two partial sums.
    pub fn join(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            sum: self.sum + other.sum,
            directions: self.directions + other.directions,
        }
    }

    /// Mean contribution of the directions; 0 without directions.
    pub fn mean(self) -> f32 {
        self.sum / self.directions.max(1.0)
    }

    /// `V`; 0 if all contributions are black. `darkest` is a radiance, 0 for relative errors everywhere.
    pub fn relative(self, darkest: f32) -> f32 {
        let directions = self.directions.max(1.0);
        let mean = self.mean().max(darkest);
        if mean < BLACK {
            return 0.0;
        }
        limited(self.squares / directions / mean / mean)
    }
}

/// Factor from `demand` to samples for an average of `samples` per shaded pixel, given the mean of `demand` over these
/// pixels, before [`sample_count`] clamps the counts. 0 if nothing varies.
pub fn sample_scale(mean_demand: f32, samples: f32) -> f32 {
    if mean_demand > 0.0 { limited(samples / mean_demand) } else { 0.0 }
}

/// Samples of a shaded pixel (equation 7): `scale demand`, rounded up and clamped to `fewest..=most`. `most` is at most
/// 2^24.
///
/// `demand` is `V` for equal relative errors, as in the paper, or its square root, weighted by the visibility of
/// errors, for the least squared error of a rendering (`propagation.md`, step 6).
pub fn sample_count(demand: f32, scale: f32, fewest: u32, most: u32) -> u32 {
    let samples_needed = limited(scale * demand).ceil();
    samples_needed.max(fewest as f32).min(most as f32) as u32
}

fn limited(value: f32) -> f32 {
    value.min(UNLIMITED)
}

#[cfg(test)]
mod tests;
