//! One run must not take the others with it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::fault::{Cause, Fault};

/// Flies one run. Its failure or panic becomes the `Err` inside; only Ctrl-C and a file system that refuses, which are
/// nobody's run, end everything.
pub fn attempt<T>(fly: impl FnOnce() -> Result<T, Fault>) -> Result<Result<T, Fault>, Fault> {
    match catch_unwind(AssertUnwindSafe(fly)) {
        Ok(Err(fault)) if matches!(fault.cause, Cause::Interrupted | Cause::Io) => Err(fault),
        Ok(flown) => Ok(flown),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| text.to_string())).unwrap_or_default();
            Ok(Err(Fault::new(Cause::Failure, format_args!("panicked: {text}"))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_stay_with_their_run_and_interrupts_do_not() {
        let fail = |cause| attempt::<()>(|| Err(Fault::new(cause, "no luck")));
        assert_eq!(fail(Cause::Gpu).unwrap().unwrap_err().cause, Cause::Gpu);
        assert_eq!(fail(Cause::Interrupted).unwrap_err().cause, Cause::Interrupted);
        let panicked = attempt::<()>(|| panic!("at the\ndisco")).unwrap().unwrap_err();
        assert_eq!(panicked.to_string(), "panicked: at the disco");
        assert_eq!(attempt(|| Ok(5)).unwrap().unwrap(), 5);
    }
}
