//! The program as a user runs it: arguments in, tables, files, one-line errors and exit codes out.

mod bench;
mod dem;
mod live;
mod maps;
mod mesh;
mod program;
mod refusals;
