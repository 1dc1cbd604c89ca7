//! What is encoded: pictures of one view under known lights.

use brdfc_formats::FormatError;

/// Fewest and most lights.
pub const LIGHTS: std::ops::RangeInclusive<usize> = 1..=4096;

/// Largest difference of a coordinate of two lights that are one: a twentieth of a degree.
const SAME_LIGHT: f32 = 1e-3;

/// Pictures of one view, each under a distant light.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSamples {
    /// Columns and rows of every picture.
    pub size: [usize; 2],
    /// Unit vectors to the lights, above the horizon.
    pub lights: Vec<[f32; 3]>,
    /// Linear RGB of each picture, row by row from the top; 1 is white. Below 0 is only what polynomials are there.
    pub pictures: Vec<Vec<[f32; 3]>>,
    /// Whether they are tiles that repeat.
    pub repeats: bool,
    /// Which texels are defined, row by row; `None` for all. Others hold whatever fills holes: they are fitted like all, but
    /// nothing is chosen by them, and no error counts them.
    pub defined: Option<Vec<bool>>,
}

impl LightSamples {
    /// Whether everything is in range.
    ///
    /// # Errors
    /// No lights or too many; sides of 0 or beyond what packs hold; pictures of another size than the first, or another
    /// number of them than of lights; lights that are not above the horizon; values that are no finite numbers; a mask
    /// of another size, or of no texel.
    pub fn check(&self) -> Result<(), FormatError> {
        let refused = |field: String, found: String, allowed: String| Err(FormatError::whole(field, found, allowed));
        if !LIGHTS.contains(&self.lights.len()) {
            let allowed = format!("{} to {}", LIGHTS.start(), LIGHTS.end());
            return refused("lights".to_owned(), self.lights.len().to_string(), allowed);
        }
        let [width, height] = self.size;
        let most = brdfc_formats::pwt::MAX_SIDE as usize;
        if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
            return refused("size".to_owned(), format!("{width} x {height}"), format!("1 to {most} along each side"));
        }
        if self.pictures.len() != self.lights.len() {
            let allowed = format!("{}, one for each light", self.lights.len());
            return refused("pictures".to_owned(), self.pictures.len().to_string(), allowed);
        }
        for (k, (picture, light)) in self.pictures.iter().zip(&self.lights).enumerate() {
            if picture.len() != width * height {
                let found = format!("{} pixels", picture.len());
                return refused(format!("picture {k}"), found, format!("{width} x {height}"));
            }
            let length: f32 = light.iter().map(|c| c * c).sum();
            if !((length - 1.0).abs() <= 1e-4 && light[2] > 0.0) {
                let allowed = "a unit vector above the horizon".to_owned();
                return refused(format!("light {k}"), format!("{light:?}"), allowed);
            }
            if let Some(at) = picture.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite())) {
                let found = format!("{:?} at ({}, {})", picture[at], at % width, at / width);
                return refused(format!("picture {k}"), found, "finite values".to_owned());
            }
        }
        if let Some(mask) = &self.defined {
            if mask.len() != width * height {
                let found = format!("{} texels", mask.len());
                return refused("mask of defined texels".to_owned(), found, format!("{width} x {height}"));
            }
            if !mask.contains(&true) {
                return refused("defined texels".to_owned(), "none".to_owned(), "one or more".to_owned());
            }
        }
        Ok(())
    }

    /// Whether a texel is defined.
    pub fn is_defined(&self, texel: usize) -> bool {
        self.defined.as_ref().is_none_or(|mask| mask[texel])
    }

    /// So many of the defined texels, or all where they are fewer: in steps of the golden ratio, so that no column or row is
    /// missed.
    pub fn spread_texels(&self, most: usize) -> Vec<usize> {
        let defined: Vec<usize> = (0..self.size[0] * self.size[1]).filter(|texel| self.is_defined(*texel)).collect();
        let count = defined.len();
        if count <= most {
            return defined;
        }
        let nth = |k: usize| ((k as f64 * 0.618_033_988_749_894_9).fract() * count as f64) as usize;
        (0..most).map(|k| defined[nth(k)]).collect()
    }

    /// How many texels are defined.
    pub fn defined_texels(&self) -> usize {
        let all = self.size[0] * self.size[1];
        self.defined.as_ref().map_or(all, |mask| mask.iter().filter(|defined| **defined).count())
    }

    /// The middle of every picture, with sides that are multiples of a number; as they are where a side is smaller.
    pub fn cropped(&self, multiple: usize) -> Self {
        let [width, height] = self.size;
        let size = self.size.map(|side| if side < multiple { side } else { side - side % multiple });
        let first = [(width - size[0]) / 2, (height - size[1]) / 2];
        let at = |y: usize| (first[1] + y) * width + first[0]..(first[1] + y) * width + first[0] + size[0];
        let rows = |picture: &Vec<[f32; 3]>| (0..size[1]).flat_map(|y| &picture[at(y)]).copied().collect();
        let pictures = self.pictures.iter().map(rows).collect();
        let defined = self.defined.as_ref().map(|mask| (0..size[1]).flat_map(|y| &mask[at(y)]).copied().collect());
        Self { size, lights: self.lights.clone(), pictures, repeats: self.repeats, defined }
    }

    /// Each light once, with the mean of its pictures: a picture that is left out is not to be predicted by another under the
    /// same light.
    #[must_use]
    pub fn averaged(mut self) -> Self {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (k, light) in self.lights.iter().enumerate() {
            let same = |group: &&mut Vec<usize>| {
                light.iter().zip(&self.lights[group[0]]).all(|(a, b)| (a - b).abs() <= SAME_LIGHT)
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.push(k),
                None => groups.push(vec![k]),
            }
        }
        if groups.len() == self.lights.len() {
            return self;
        }
        let mean = |group: &Vec<usize>| {
            let mut picture = std::mem::take(&mut self.pictures[group[0]]);
            for other in &group[1..] {
                picture
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(self.pictures[*other].as_flattened())
                    .for_each(|(a, b)| *a += b);
            }
            let count = group.len() as f32;
            picture.as_flattened_mut().iter_mut().for_each(|value| *value /= count);
            picture
        };
        self.pictures = groups.iter().map(mean).collect();
        self.lights = groups.iter().map(|group| self.lights[group[0]]).collect();
        self
    }

    /// Without some of the lights.
    pub fn without(&self, left_out: &[usize]) -> Self {
        let kept = (0..self.lights.len()).filter(|k| !left_out.contains(k));
        let (lights, pictures) = kept.map(|k| (self.lights[k], self.pictures[k].clone())).unzip();
        Self { size: self.size, lights, pictures, repeats: self.repeats, defined: self.defined.clone() }
    }
}
