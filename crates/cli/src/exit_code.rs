//! The exit codes of the command.

/// The arguments are wrong, or the threads could not be started. `clap` uses the same code.
pub(crate) const USAGE: u8 = 2;
/// The scene, or a result to compare, is not valid.
pub(crate) const SCENE: u8 = 3;
/// A run failed or no method was found, and the results are written; or the study could not run.
pub(crate) const FAILED: u8 = 4;
/// The results could not be written.
pub(crate) const STORAGE: u8 = 5;
/// Added to the number of the signal that ended the command: 130 after Ctrl-C, 143 after SIGTERM.
pub(crate) const SIGNAL: u8 = 128;

/// The codes, for the end of the help text.
pub(crate) const HELP: &str = "\
Exit codes:
  0    completed; of `paper` also where runs fail, as some are meant to
  2    invalid command line
  3    the scene, a result to compare, or parts to join are not valid
  4    some runs failed, or no method was found (the results are written);
       the study could not be run; or cells to merge are missing
  5    the results could not be written, or would replace others
  130  interrupted by Ctrl-C (all finished work is written)
  143  terminated by SIGTERM (all finished work is written)
       A second signal ends the command at once, and nothing is written.";
