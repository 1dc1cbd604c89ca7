//! How fast reflected light varies in a picture: propagation of local bandwidth from a light to a pixel, and the
//! sampling rates that follow. Rules in words: `spec/bandwidth-propagation.md`.
//!
//! After "Interactive rendering of acquired materials on dynamic geometry using bandwidth prediction" (2012), sections
//! 2.1 to 2.3 and figure 5; equation numbers are theirs. Signs of shears are dropped, so that every result is an upper
//! bound. [`PROPAGATION_WGSL`] has the same functions with the same steps: the bits are equal where additions,
//! multiplications, divisions and square roots are rounded correctly and not fused.
//!
//! Every number that goes in is finite and not negative; every number that comes out is, too.

/// The same functions in WGSL, without bindings.
pub const PROPAGATION_WGSL: &str = include_str!("../shaders/bandwidth_propagation.wgsl");

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
    pub fn reflected(self, surface: Surface) -> Self {
        self.into_surface(surface.cos_incoming)
            .curvature(surface.curvature)
            .reflection(surface.lobe, surface.texture)
            .curvature(surface.curvature)
            .out_of_surface(surface.cos_outgoing)
    }

    /// Equation 4: from the light to the image plane, over one reflection. `light_distance` and `image_distance`, `d` and
    /// `d'`, are in metres. Of light from far away the spatial bandwidth is 0, so that its distance does not matter:
    /// give 0.
    pub fn one_bounce(self, light_distance: f32, surface: Surface, image_distance: f32) -> Self {
        self.flight(light_distance).reflected(surface).flight(image_distance)
    }
}

/// What reflects a ray: the parameters of [`Bandwidth::reflected`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
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

impl Surface {
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

/// The factor from `V` to samples that spends `samples` per shaded pixel where the mean of `V` over them is
/// `mean_variance`, before [`sample_count`] holds them to its range. 0 where nothing varies.
pub fn sample_scale(mean_variance: f32, samples: f32) -> f32 {
    if mean_variance > 0.0 { limited(samples / mean_variance) } else { 0.0 }
}

/// Samples of a shaded pixel: `scale V`, rounded up, in the range `fewest..=most`. `most` is at most 2^24.
pub fn sample_count(variance: f32, scale: f32, fewest: u32, most: u32) -> u32 {
    let wanted = limited(scale * variance).ceil();
    wanted.max(fewest as f32).min(most as f32) as u32
}

fn limited(value: f32) -> f32 {
    value.min(UNLIMITED)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn bandwidth(spatial: f32, angular: f32) -> Bandwidth {
        Bandwidth { spatial, angular }
    }

    const SURFACE: Surface = Surface { cos_incoming: 0.5, cos_outgoing: 0.5, curvature: 2.0, lobe: 4.0, texture: 3.0 };

    #[test]
    fn each_operator_by_hand() {
        let v = bandwidth(3.0, 5.0);
        assert_eq!(v.flight(2.0), bandwidth(3.0, 11.0));
        assert_eq!(v.into_surface(0.25), bandwidth(0.75, 5.0));
        assert_eq!(v.curvature(2.0), bandwidth(13.0, 5.0));
        assert_eq!(v.reflection(4.0, 0.5), bandwidth(3.5, 4.0));
        assert_eq!(v.reflection(6.0, 0.0), v);
        assert_eq!(v.out_of_surface(0.25), bandwidth(12.0, 5.0));
    }

    #[test]
    fn a_bounce_by_hand() {
        // 0, 10 -> 0, 10 -> 20, 10 -> 23, 4 -> 31, 4 -> 62, 4 -> 62, 128
        assert_eq!(Bandwidth::distant(10.0).one_bounce(0.0, SURFACE, 2.0), bandwidth(62.0, 128.0));
        // 1, 2 -> 1, 5 -> 0.5, 5 -> 10.5, 5 -> 13.5, 4 -> 21.5, 4 -> 43, 4 -> 43, 90
        assert_eq!(bandwidth(1.0, 2.0).one_bounce(3.0, SURFACE, 2.0), bandwidth(43.0, 90.0));
        // Each parameter matters.
        for (changed, field) in [
            (Surface { cos_incoming: 0.25, ..SURFACE }, "cos_incoming"),
            (Surface { cos_outgoing: 0.25, ..SURFACE }, "cos_outgoing"),
            (Surface { curvature: 1.0, ..SURFACE }, "curvature"),
            (Surface { lobe: 3.0, ..SURFACE }, "lobe"),
            (Surface { texture: 2.0, ..SURFACE }, "texture"),
        ] {
            assert_ne!(bandwidth(1.0, 2.0).one_bounce(3.0, changed, 2.0), bandwidth(43.0, 90.0), "{field}");
        }
    }

    #[test]
    fn nothing_in_nothing_out() {
        let surface = Surface { texture: 0.0, ..SURFACE };
        assert_eq!(Bandwidth::default().one_bounce(7.0, surface, 9.0), Bandwidth::default());
        assert_eq!(BandwidthAverage::default().mean(), Bandwidth::default());
        assert_eq!(BandwidthAverage::default().add(bandwidth(3.0, 4.0), 0.0).mean(), Bandwidth::default());
        assert_eq!(VarianceEstimate::default().relative(0.0), 0.0);
        assert_eq!(VarianceEstimate::default().add(0.0, 0.0, 5.0).relative(0.0), 0.0);
    }

    /// Around a ball of radius ½ from 4 away, the viewer's angle to the normal turns by `1 + d' / (R cos θo)`.
    #[test]
    fn albedo_varies_with_the_viewers_angle() {
        let ball = Surface { cos_outgoing: 0.5, curvature: 2.0, ..SURFACE };
        assert_eq!(ball.albedo(4.0).angular, 0.5 * (1.0 + 4.0 * 2.0 / 0.5));
        assert_eq!(Surface { lobe: 0.0, ..ball }.albedo(4.0), Bandwidth::default());
        assert_eq!(Surface { lobe: 0.25, ..ball }.albedo(4.0).angular, 0.25 * 17.0);
    }

    #[test]
    fn parts_of_sums_add_up() {
        let light = DirectedLight::of(2.0, 5.0, 3.0);
        assert_eq!(light.moments(), [2.0, 6.0, 5.0, 15.0]);
        assert_eq!(DirectedLight::from_moments(light.moments()), light);
        assert_eq!(DirectedLight::from_moments([0.0; 4]), DirectedLight::default());
        // One direction as a range is that direction.
        let start = VarianceEstimate::default().add(1.0, 2.0, 4.0);
        assert_eq!(start.add_range(DirectedLight::of(3.0, 9.0, 5.0), 7.0), start.add(5.0, 7.0, 3.0));
        assert_eq!(start.join(VarianceEstimate::default().add(5.0, 7.0, 3.0)), start.add(5.0, 7.0, 3.0));
        assert_eq!(start.add(5.0, 7.0, 2.0).mean(), 3.0);
        let average = BandwidthAverage::default().add(bandwidth(1.0, 2.0), 3.0);
        let other = BandwidthAverage::default().add(bandwidth(5.0, 7.0), 1.0);
        assert_eq!(average.join(other), average.add(bandwidth(5.0, 7.0), 1.0));
        assert_eq!(average.join(other).mean(), bandwidth(2.0, 3.25));
    }

    #[test]
    fn a_plane_under_a_distant_light_varies_with_direction_alone() {
        let plane = Surface { curvature: 0.0, texture: 0.0, ..SURFACE };
        for (light, lobe) in [(10.0, 4.0), (3.0, 4.0)] {
            let seen = Bandwidth::distant(light).one_bounce(0.0, Surface { lobe, ..plane }, 50.0);
            assert_eq!(seen, bandwidth(0.0, lobe.min(light)));
        }
        // Not so a texture, a curved surface, or a light close by.
        let textured = Surface { texture: 1.0, ..plane };
        assert_eq!(Bandwidth::distant(3.0).one_bounce(0.0, textured, 50.0), bandwidth(2.0, 103.0));
        assert!(Bandwidth::distant(3.0).one_bounce(0.0, Surface { curvature: 0.1, ..plane }, 50.0).spatial > 0.0);
        assert!(bandwidth(1.0, 3.0).one_bounce(1.0, plane, 50.0).spatial > 0.0);
    }

    /// In a mirror ball of radius R, seen from d', a pixel's angle α moves by `d' α / cos θo` on the ball; the normal
    /// turns by that over R, the reflected ray by twice as much and by α.
    #[test]
    fn a_mirror_ball_shows_what_geometry_says() {
        for (radius, distance, cosine, light) in [(0.5, 4.0, 1.0, 3.0), (0.1, 2.0, 0.5, 7.0), (2.0, 0.25, 0.25, 1.5)] {
            let ball = Surface {
                cos_incoming: cosine,
                cos_outgoing: cosine,
                curvature: 1.0 / radius,
                lobe: UNLIMITED,
                texture: 0.0,
            };
            let seen = Bandwidth::distant(light).one_bounce(0.0, ball, distance).angular;
            let expected = light * (1.0 + 2.0 * distance / (radius * cosine));
            assert!((seen / expected - 1.0).abs() < 1e-6, "{seen} {expected}");
        }
    }

    #[test]
    fn everything_stays_finite() {
        let all = [0.0, 1e-40, 1.0, 1e3, UNLIMITED];
        for spatial in all {
            for angular in all {
                for texture in all {
                    for cosine in [0.0, 1e-30, 1.0] {
                        let surface = Surface {
                            cos_incoming: cosine,
                            cos_outgoing: cosine,
                            curvature: 1e9,
                            lobe: UNLIMITED,
                            texture,
                        };
                        let seen = bandwidth(spatial, angular).one_bounce(1e9, surface, 1e9);
                        assert!(seen.spatial <= UNLIMITED && seen.angular <= UNLIMITED, "{seen:?}");
                        let mut variance = VarianceEstimate::default();
                        let mut average = BandwidthAverage::default();
                        for contribution in [0.0, 1e-30, 1e-18, 1.0, 1e38] {
                            variance = variance.add(angular, spatial, contribution);
                            average = average.add(seen, contribution);
                            assert!(variance.relative(0.0) <= UNLIMITED);
                            assert!(average.mean().angular <= UNLIMITED && average.mean().spatial <= UNLIMITED);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_mean_is_weighted() {
        let average = BandwidthAverage::default().add(bandwidth(1.0, 2.0), 3.0).add(bandwidth(5.0, 6.0), 1.0);
        assert_eq!(average.mean(), bandwidth(2.0, 3.0));
        // Brightness alone changes nothing; a maximum would be (5, 6).
        let dim = BandwidthAverage::default().add(bandwidth(1.0, 2.0), 0.375).add(bandwidth(5.0, 6.0), 0.125);
        assert_eq!(dim.mean(), average.mean());
    }

    #[test]
    fn pixels_by_hand() {
        // 1/128 radian per pixel across and 1/256 down; then 1/256 across and 1/128 down.
        assert_eq!(pixel_bandwidth(25.0, [1.0, 0.5], [128.0, 128.0], 0.5), 0.1953125);
        assert_eq!(pixel_bandwidth(25.0, [1.0, 0.5], [256.0, 64.0], 0.5), 0.1953125);
        assert_eq!(pixel_bandwidth(1e6, [1.0, 0.5], [128.0, 128.0], largest_pixel_bandwidth(0)), 0.5);
        assert_eq!(pixel_bandwidth(1e6, [1.0, 0.5], [128.0, 128.0], largest_pixel_bandwidth(2)), 2.0);
        assert_eq!(pixel_bandwidth(0.0, [1.0, 0.5], [128.0, 128.0], 0.5), 0.0);
    }

    #[test]
    fn levels_by_hand() {
        for (bandwidth, level) in [
            (0.5, 0),
            (0.4, 0),
            (0.25, 1),
            (0.250_000_03, 0),
            (0.249_999_98, 1),
            (0.125, 2),
            (0.001, 8),
            (1.0, -1),
            (2.0, -2),
            (1.5, -2),
            (0.0, 9),
            (1e-45, 9),
            (1e-6, 9),
        ] {
            assert_eq!(pyramid_level(bandwidth, 9), level, "{bandwidth}");
        }
        // The Nyquist rate holds, and the next coarser level would not do.
        for step in 1..2000 {
            let bandwidth = step as f32 * 7.7e-4;
            let level = pyramid_level(bandwidth, 100);
            let rate = (-level as f32).exp2();
            assert!(rate >= 2.0 * bandwidth && 0.5 * rate < 2.0 * bandwidth, "{bandwidth}: {level}");
        }
    }

    #[test]
    fn variance_by_hand() {
        let even = VarianceEstimate::default().add(3.0, 1.0, 2.0).add(3.0, 1.0, 2.0);
        assert_eq!(even.relative(0.0), 4.0);
        // All light from one of the directions: twice the variance. The sum that the paper prints sees no difference.
        let uneven = VarianceEstimate::default().add(3.0, 1.0, 4.0).add(3.0, 1.0, 0.0);
        assert_eq!(uneven.relative(0.0), 8.0);
        // Exposure changes nothing, unless the pixel is too dark to matter.
        let dim = VarianceEstimate::default().add(3.0, 1.0, 0.25).add(3.0, 1.0, 0.25);
        assert_eq!((dim.relative(0.0), dim.relative(0.125), dim.relative(0.5)), (4.0, 4.0, 1.0));
    }

    #[test]
    fn samples_by_hand() {
        assert_eq!(sample_count(4.0, 2.5, 4, 64), 10);
        assert_eq!(sample_count(4.1, 2.5, 4, 64), 11);
        assert_eq!((sample_count(0.0, 2.5, 4, 64), sample_count(1e9, 1e9, 4, 64)), (4, 64));
        let scale = sample_scale(8.0, 100.0);
        assert_eq!((scale, sample_count(8.0, scale, 1, 1000)), (12.5, 100));
        assert_eq!(sample_scale(0.0, 100.0), 0.0);
    }
}
