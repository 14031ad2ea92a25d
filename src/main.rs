//! The door for the terminal.

fn main() -> std::process::ExitCode {
    celfx::cli::main()
}
