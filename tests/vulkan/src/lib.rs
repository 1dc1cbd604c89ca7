//! Nothing: the tests of this package hand SPIR-V to a Vulkan driver as it is, by a function that is unsafe.
