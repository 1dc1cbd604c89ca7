//! Environment variables of graphics drivers.

/// Restarts the program if `XDG_RUNTIME_DIR` is not set: a layer of Mesa's Vulkan driver would report that on stderr, although
/// no display is needed. The variable cannot be set in a process whose threads may read it.
#[cfg(target_os = "linux")]
pub fn prepare() {
    use std::os::unix::process::CommandExt;
    const NAME: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(NAME).is_some() {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    // Returns only if it fails; then the driver's message stays.
    let _ =
        std::process::Command::new(program).args(std::env::args_os().skip(1)).env(NAME, std::env::temp_dir()).exec();
}

/// No-op on other systems.
#[cfg(not(target_os = "linux"))]
pub fn prepare() {}
