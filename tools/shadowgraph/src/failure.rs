//! How a command fails: what is told, and the exit code.

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

/// Result of a command.
pub type Result<T, E = Failure> = std::result::Result<T, E>;

/// Why a command failed.
#[derive(Debug)]
pub struct Failure {
    /// 1: it failed. 2: bad usage or bad input.
    code: u8,
    /// What failed, then its causes.
    chain: Vec<String>,
}

impl Failure {
    /// Bad usage or bad input: another argument or another file would help.
    pub fn input(error: impl Into<Box<dyn Error>>) -> Self {
        Self { code: 2, chain: chain(error.into().as_ref()) }
    }

    /// It could have worked.
    pub fn failed(error: impl Into<Box<dyn Error>>) -> Self {
        Self { code: 1, chain: chain(error.into().as_ref()) }
    }

    /// Tells it on standard error and gives the exit code.
    pub fn report(&self) -> ExitCode {
        // Where standard error is closed there is nobody to tell.
        let _ = write!(std::io::stderr().lock(), "{self}");
        ExitCode::from(self.code)
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut causes = self.chain.iter();
        writeln!(f, "error: {}", causes.next().map_or("unknown", String::as_str))?;
        causes.try_for_each(|cause| writeln!(f, "  caused by: {cause}"))
    }
}

/// An engine's error is a failure; where it is the user's input that is bad, the caller says [`Failure::input`].
impl From<shadowgraph::Error> for Failure {
    fn from(error: shadowgraph::Error) -> Self {
        Self::failed(error)
    }
}

/// What an error and its sources say, without sources that their error has quoted already.
fn chain(error: &dyn Error) -> Vec<String> {
    let mut texts = vec![error.to_string()];
    let mut source = error.source();
    while let Some(cause) = source {
        let text = cause.to_string();
        if !texts.iter().any(|told| told.contains(&text)) {
            texts.push(text);
        }
        source = cause.source();
    }
    texts
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[derive(Debug)]
    struct Outer(io::Error);
    impl std::fmt::Display for Outer {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("the scene cannot be opened")
        }
    }
    impl Error for Outer {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            Some(&self.0)
        }
    }

    #[test]
    fn causes_are_told_once() {
        let failure = Failure::input(Outer(io::Error::other("disk on fire")));
        assert_eq!(failure.to_string(), "error: the scene cannot be opened\n  caused by: disk on fire\n");
        let quoting = shadowgraph::Error::io("read", "x.glb", io::Error::other("disk on fire"));
        assert_eq!(Failure::failed(quoting).to_string(), "error: cannot read x.glb: disk on fire\n");
    }
}
