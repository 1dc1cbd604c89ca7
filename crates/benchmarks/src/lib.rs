//! Benchmarks alone: `cargo bench -p brdfc-benchmarks`. Apart from the rest so that tests need not compile their tools.
