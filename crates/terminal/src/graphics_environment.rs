//! What graphics drivers look for in the environment.

/// Runs the program once more where `XDG_RUNTIME_DIR` is not set: a layer of Mesa's Vulkan driver would complain about
/// that on stderr, though no display is needed. The variable cannot be set in a process whose threads may read it.
#[cfg(target_os = "linux")]
pub fn prepare() {
    use std::os::unix::process::CommandExt;
    const NAME: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(NAME).is_some() {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    // Only returns if it fails; then the complaint stays.
    let _ =
        std::process::Command::new(program).args(std::env::args_os().skip(1)).env(NAME, std::env::temp_dir()).exec();
}

/// Nothing to do elsewhere.
#[cfg(not(target_os = "linux"))]
pub fn prepare() {}
