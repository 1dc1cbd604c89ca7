//! Empty: the tests of this package pass SPIR-V to a Vulkan driver unchanged, with a function that is unsafe.
