// The command line of `pleinair` and `pleinair-mpi`.
#pragma once

namespace pleinair {

// The program's exit code: 0, or 2 with one line on standard error.
int RunCommandLine(int argc, char** argv);

}  // namespace pleinair
