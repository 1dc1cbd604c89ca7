//! Writes tensor containers and small synthetic RGL materials.

use std::f32::consts::FRAC_PI_2;

/// One named array.
#[derive(Clone)]
pub struct Field {
    pub name: Vec<u8>,
    pub code: u8,
    pub shape: Vec<u64>,
    pub data: Vec<u8>,
}

/// Fields in file order; the data follow the headers, each at a multiple of 8 bytes.
#[derive(Clone, Default)]
pub struct Container {
    pub fields: Vec<Field>,
}

impl Container {
    pub fn f32(mut self, name: &str, shape: &[u64], values: impl IntoIterator<Item = f32>) -> Self {
        let data: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
        assert_eq!(data.len() as u64, 4 * shape.iter().product::<u64>(), "{name}");
        self.fields.push(Field { name: name.into(), code: 10, shape: shape.to_vec(), data });
        self
    }

    pub fn u8(mut self, name: &str, values: &[u8]) -> Self {
        let shape = vec![values.len() as u64];
        self.fields.push(Field { name: name.into(), code: 1, shape, data: values.to_vec() });
        self
    }

    pub fn field(&mut self, name: &str) -> &mut Field {
        self.fields.iter_mut().find(|f| f.name == name.as_bytes()).unwrap()
    }

    pub fn without(mut self, name: &str) -> Self {
        self.fields.retain(|f| f.name != name.as_bytes());
        self
    }

    /// Byte offset of the header of each field, and of the end of the headers.
    pub fn header_offsets(&self) -> Vec<usize> {
        let mut offsets = vec![18];
        for f in &self.fields {
            offsets.push(offsets[offsets.len() - 1] + 2 + f.name.len() + 2 + 1 + 8 + 8 * f.shape.len());
        }
        offsets
    }

    /// Byte offset of the data of each field.
    pub fn data_offsets(&self) -> Vec<usize> {
        let mut end = *self.header_offsets().last().unwrap();
        let mut offsets = Vec::new();
        for f in &self.fields {
            offsets.push(end.next_multiple_of(8));
            end = offsets[offsets.len() - 1] + f.data.len();
        }
        offsets
    }

    pub fn build(&self) -> Vec<u8> {
        let offsets = self.data_offsets();
        let mut bytes = b"tensor_file\0\x01\x00".to_vec();
        bytes.extend((self.fields.len() as u32).to_le_bytes());
        for (f, offset) in self.fields.iter().zip(&offsets) {
            bytes.extend((f.name.len() as u16).to_le_bytes());
            bytes.extend(&f.name);
            bytes.extend((f.shape.len() as u16).to_le_bytes());
            bytes.push(f.code);
            bytes.extend((*offset as u64).to_le_bytes());
            bytes.extend(f.shape.iter().flat_map(|extent| extent.to_le_bytes()));
        }
        for (f, offset) in self.fields.iter().zip(&offsets) {
            bytes.resize(*offset, 0);
            bytes.extend(&f.data);
        }
        bytes
    }
}

/// Position at which a colour is evaluated.
#[derive(Clone, Copy)]
pub struct At {
    pub phi: usize,
    pub theta: usize,
    pub channel: usize,
    /// 0 to 1 along v.
    pub t: f32,
    /// 0 to 1 along u.
    pub s: f32,
}

/// A synthetic material. The tables of `ndf` and `sigma` are constant.
pub struct Material {
    pub phi_i: Vec<f32>,
    pub theta_i: Vec<f32>,
    pub ndf: f32,
    pub sigma: f32,
    /// Density at (u, v).
    pub vndf: fn(f32, f32) -> f32,
    /// Nodes of the tables of visible normals and of colour, along each axis.
    pub nodes: usize,
    /// `None` for RGB.
    pub wavelengths: Option<Vec<f32>>,
    pub colour: fn(At) -> f32,
    pub jacobian: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            phi_i: vec![0.0],
            theta_i: vec![0.0, FRAC_PI_2],
            ndf: 2.0,
            sigma: 0.5,
            vndf: |_, _| 1.0,
            nodes: 2,
            wavelengths: None,
            colour: |at| [0.5, 0.25, 0.125][at.channel],
            jacobian: true,
        }
    }
}

impl Material {
    pub fn container(&self) -> Container {
        let (phis, thetas, n) = (self.phi_i.len(), self.theta_i.len(), self.nodes);
        let channels = self.wavelengths.as_ref().map_or(3, Vec::len);
        let unit = |k: usize| k as f32 / (n - 1) as f32;
        let mut vndf = Vec::new();
        let mut colours = Vec::new();
        for phi in 0..phis {
            for theta in 0..thetas {
                vndf.extend((0..n * n).map(|k| (self.vndf)(unit(k % n), unit(k / n))));
                for channel in 0..channels {
                    colours.extend(
                        (0..n * n).map(|k| (self.colour)(At { phi, theta, channel, t: unit(k / n), s: unit(k % n) })),
                    );
                }
            }
        }
        let [p, t, c, n] = [phis, thetas, channels, n].map(|v| v as u64);
        let container = Container::default()
            .u8("description", b"test")
            .f32("phi_i", &[p], self.phi_i.iter().copied())
            .f32("theta_i", &[t], self.theta_i.iter().copied())
            .f32("ndf", &[2, 2], [self.ndf; 4])
            .f32("sigma", &[2, 2], [self.sigma; 4])
            .f32("vndf", &[p, t, n, n], vndf)
            .f32("luminance", &[p, t, n, n], (0..p * t * n * n).map(|_| 1.0))
            .u8("jacobian", &[u8::from(self.jacobian)]);
        match &self.wavelengths {
            None => container.f32("rgb", &[p, t, c, n, n], colours),
            Some(wavelengths) => container.f32("wavelengths", &[c], wavelengths.iter().copied()).f32(
                "spectra",
                &[p, t, c, n, n],
                colours,
            ),
        }
    }
}
