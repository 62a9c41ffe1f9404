//! The program as a user runs it: arguments in, tables, files, one-line errors and exit codes out.

mod bench;
mod benches;
mod cells;
mod compare;
mod dem;
mod disk;
mod figures;
mod live;
mod maps;
mod mesh;
mod program;
mod refusals;
mod repeats;
mod report;
mod resume;
mod schema;
mod voids;
