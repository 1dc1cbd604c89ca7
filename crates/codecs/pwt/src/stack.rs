//! Input of the encoder: images of one view, or of the views of a BTF, under known lights.

use crate::views::Views;
use brdfc_formats::FormatError;
use brdfc_readers::near_lights::NearLights;
use brdfc_readers::pixels::Pixels;
use std::borrow::Cow;

/// Range of the number of lights.
pub const LIGHTS: std::ops::RangeInclusive<usize> = 1..=4096;

/// Largest difference between coordinates of lights that count as one: a twentieth of a degree.
const SAME_LIGHT: f32 = 1e-3;

/// At most `most` of the numbers below `count`: all of them, or steps of the golden ratio, which no period of a list meets.
pub fn spread(count: usize, most: usize) -> Vec<usize> {
    let nth = |k: usize| ((k as f64 * 0.618_033_988_749_894_9).fract() * count as f64) as usize;
    if count <= most { (0..count).collect() } else { (0..most).map(nth).collect() }
}

/// Images of one view, each under one light. Images of several views are stacked: view `v` is the rows `v h` to
/// `(v + 1) h - 1` of the image of every light, where `h` is the height of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSamples {
    /// Columns and rows of every image, with all views.
    pub size: [usize; 2],
    /// Unit vectors to the lights, above the horizon; for near lights from the middle of the images.
    pub lights: Vec<[f32; 3]>,
    /// RGB of each image, row by row from the top; 1 is white. Only polynomials have values below 0.
    pub images: Vec<Pixels>,
    /// Positions of the lights, if they are near; [`Self::distant`] converts such images.
    pub near: Option<NearLights>,
    /// True if the images are tiles that repeat.
    pub repeats: bool,
    /// Directions of two or more views; `None` for one.
    pub views: Option<Views>,
    /// Mask of defined texels, row by row; `None` if all are defined. Other texels hold filled values: they are fitted,
    /// but do not affect choices and errors.
    pub defined: Option<Vec<bool>>,
}

impl LightSamples {
    /// Images under distant lights that do not repeat and whose texels are all defined.
    pub fn new(size: [usize; 2], lights: Vec<[f32; 3]>, images: Vec<impl Into<Pixels>>) -> Self {
        let images = images.into_iter().map(Into::into).collect();
        Self { size, lights, images, near: None, repeats: false, views: None, defined: None }
    }

    /// Checks the input.
    ///
    /// # Errors
    /// Returns an error for no lights or too many, for sides of 0 or beyond the limits of packs, for images of another
    /// size or number than expected, for lights that are not unit vectors above the horizon, for values that are not
    /// finite, and for a mask of another size or without defined texels.
    pub fn check(&self) -> Result<(), FormatError> {
        let refused = |field: String, found: String, allowed: String| Err(FormatError::whole(field, found, allowed));
        if !LIGHTS.contains(&self.lights.len()) {
            let allowed = format!("{} to {}", LIGHTS.start(), LIGHTS.end());
            return refused("lights".to_owned(), self.lights.len().to_string(), allowed);
        }
        self.check_views()?;
        let [width, height] = self.size;
        let most = brdfc_formats::pwt::MAX_SIDE as usize;
        if self.view_size().iter().any(|side| !(1..=most).contains(side)) {
            return refused("size".to_owned(), format!("{width} x {height}"), format!("1 to {most} along each side"));
        }
        if self.images.len() != self.lights.len() {
            let allowed = format!("{}, one per light", self.lights.len());
            return refused("images".to_owned(), self.images.len().to_string(), allowed);
        }
        for (k, (image, light)) in self.images.iter().zip(&self.lights).enumerate() {
            if image.len() != width * height {
                let found = format!("{} pixels", image.len());
                return refused(format!("image {k}"), found, format!("{width} x {height}"));
            }
            let length: f32 = light.iter().map(|c| c * c).sum();
            if !((length - 1.0).abs() <= 1e-4 && light[2] > 0.0) {
                let allowed = "a unit vector above the horizon".to_owned();
                return refused(format!("light {k}"), format!("{light:?}"), allowed);
            }
            if let Pixels::Linear(image) = image
                && let Some(at) = image.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite()))
            {
                let found = format!("{:?} at ({}, {})", image[at], at % width, at / width);
                return refused(format!("image {k}"), found, "finite values".to_owned());
            }
        }
        if let Some(mask) = &self.defined {
            if mask.len() != width * height {
                let found = format!("{} texels", mask.len());
                return refused("mask of defined texels".to_owned(), found, format!("{width} x {height}"));
            }
            if !mask.contains(&true) {
                return Err(FormatError::whole("mask of defined texels", "no defined texels", "one or more").problem());
            }
        }
        Ok(())
    }

    /// Linear values of all images.
    pub fn into_linear(self) -> Vec<Vec<[f32; 3]>> {
        self.images.into_iter().map(Pixels::into_linear).collect()
    }

    /// Returns true if a texel is defined.
    pub fn is_defined(&self, texel: usize) -> bool {
        self.defined.as_ref().is_none_or(|mask| mask[texel])
    }

    /// At most `most` of the defined texels, in steps of the golden ratio, which covers all columns and rows.
    pub fn spread_texels(&self, most: usize) -> Vec<usize> {
        let defined: Vec<usize> = (0..self.size[0] * self.size[1]).filter(|texel| self.is_defined(*texel)).collect();
        spread(defined.len(), most).into_iter().map(|k| defined[k]).collect()
    }

    /// Number of defined texels.
    pub fn defined_texels(&self) -> usize {
        let all = self.size[0] * self.size[1];
        self.defined.as_ref().map_or(all, |mask| mask.iter().filter(|defined| **defined).count())
    }

    /// Crops every image of one view under a distant light to its middle, with sides that are multiples of `multiple`; smaller sides stay unchanged.
    pub fn cropped(&self, multiple: usize) -> Self {
        let [width, height] = self.size;
        let size = self.size.map(|side| if side < multiple { side } else { side - side % multiple });
        let first = [(width - size[0]) / 2, (height - size[1]) / 2];
        let at = |y: usize| (first[1] + y) * width + first[0]..(first[1] + y) * width + first[0] + size[0];
        let images = self.images.iter().map(|image| image.parts((0..size[1]).map(at))).collect();
        let defined = self.defined.as_ref().map(|mask| (0..size[1]).flat_map(|y| &mask[at(y)]).copied().collect());
        Self { size, lights: self.lights.clone(), images, near: None, repeats: self.repeats, views: None, defined }
    }

    /// Averages images under the same light, so that cross-validation does not predict an image from its copy.
    #[must_use]
    pub fn averaged(self) -> Self {
        let groups = self.groups(SAME_LIGHT);
        if groups.len() == self.lights.len() {
            return self;
        }
        self.of_groups(&groups)
    }

    /// Averages images under neighbouring lights, until at most `most` lights are left.
    pub fn at_most(&self, most: usize) -> Cow<'_, Self> {
        if self.lights.len() <= most {
            return Cow::Borrowed(self);
        }
        // A fraction of the distance of evenly spread lights.
        let mut apart = 1.0 / (most.max(1) as f32).sqrt();
        loop {
            let groups = self.groups(apart);
            if groups.len() <= most.max(1) {
                return Cow::Owned(self.of_groups(&groups));
            }
            apart *= 1.2;
        }
    }

    /// Groups of lights: each joins the first group whose first light differs little along all axes, and in its distance.
    fn groups(&self, most: f32) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let ratio = |a: usize, b: usize| self.near.as_ref().map_or(1.0, |near| near.distance(a) / near.distance(b));
        for (k, light) in self.lights.iter().enumerate() {
            let is_same = |group: &&mut Vec<usize>| {
                let first = group[0];
                let mut differences = light.iter().zip(&self.lights[first]).map(|(a, b)| (a - b).abs());
                differences.all(|difference| difference <= most) && (ratio(k, first) - 1.0).abs() <= f64::from(most)
            };
            match groups.iter_mut().find(is_same) {
                Some(group) => group.push(k),
                None => groups.push(vec![k]),
            }
        }
        groups
    }

    /// Means of the images and lights of groups.
    fn of_groups(&self, groups: &[Vec<usize>]) -> Self {
        let mean = |group: &Vec<usize>| {
            let mut image = self.images[group[0]].clone();
            if group.len() == 1 {
                return image;
            }
            let sums = image.to_mut().as_flattened_mut();
            for other in &group[1..] {
                let other = self.images[*other].linear(0..self.size[0] * self.size[1]);
                sums.iter_mut().zip(other.as_flattened()).for_each(|(a, b)| *a += b);
            }
            let count = group.len() as f32;
            sums.iter_mut().for_each(|value| *value /= count);
            image
        };
        let light = |group: &Vec<usize>| {
            let first = self.lights[group[0]];
            if group.iter().all(|k| self.lights[*k] == first) {
                return first;
            }
            let sum = group.iter().fold([0.0; 3], |sum, k| [0, 1, 2].map(|c| sum[c] + self.lights[*k][c]));
            let length = sum.iter().map(|c| c * c).sum::<f32>().sqrt();
            sum.map(|c| c / length)
        };
        Self {
            size: self.size,
            lights: groups.iter().map(light).collect(),
            images: groups.iter().map(mean).collect(),
            near: self.near.as_ref().map(|near| near.of_groups(groups)),
            repeats: self.repeats,
            views: self.views.clone(),
            defined: self.defined.clone(),
        }
    }

    /// The images without some of the lights.
    pub fn without(&self, left_out: &[usize]) -> Self {
        let rest = (0..self.lights.len()).filter(|k| !left_out.contains(k));
        let (lights, images) = rest.map(|k| (self.lights[k], self.images[k].clone())).unzip();
        let near = self.near.as_ref().map(|near| near.without(left_out));
        let (repeats, views, defined) = (self.repeats, self.views.clone(), self.defined.clone());
        Self { size: self.size, lights, images, near, repeats, views, defined }
    }
}
