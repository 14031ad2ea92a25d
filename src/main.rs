//! The door for the terminal.

#[global_allocator]
static MEMORY: celfx::cli::memory::Memory = celfx::cli::memory::Memory;

fn main() -> std::process::ExitCode {
    celfx::cli::main()
}
