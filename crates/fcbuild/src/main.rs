//! The command `fcbuild`: a polygon mesh in, a face-cluster tree out. See `fcbuild --help`.

mod cli;

use clap::Parser as _;
use cli::flags::Flags;
use std::process::ExitCode;

fn main() -> ExitCode {
    fct::heap::map_large_blocks();
    match Flags::try_parse() {
        Ok(flags) => cli::run(&flags),
        Err(error) => {
            // Help and version are asked for and go to stdout, the rest to stderr; a closed pipe is no concern.
            let format = fct::MessageFormat::asked_for(std::env::args_os());
            if error.use_stderr() && format == fct::MessageFormat::Json {
                cli::tell_usage(&error.render().to_string());
            } else {
                let _ = error.print();
            }
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2))
        }
    }
}
