//! Tests lobes against materials with known weights.

mod golden;
mod lobes;

use brdfc_environment::prefilter;
use brdfc_environment::training::TrainingEnvironment;
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_lobes::Environments;
use std::sync::LazyLock;

/// Small environments: noise and a studio for the fit, other noise for the error. Where light comes from few directions,
/// the bilinear filter of the coarsest level alone has a ΔE of up to 1.
static ENVIRONMENTS: LazyLock<Environments> = LazyLock::new(|| {
    let decoder = |seed: u64| {
        let environment = TrainingEnvironment::new(seed);
        let pack = prefilter(&|direction| environment.radiance(direction), 32, 2, &()).expect("radiance in range");
        EnvironmentDecoder::new(&pack)
    };
    Environments { training: [0, 2].map(decoder).to_vec(), held_out: vec![decoder(4)] }
});
