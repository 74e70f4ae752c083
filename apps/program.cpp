#include "apps/command_line.h"

int main(int argc, char** argv) { return pleinair::RunCommandLine(argc, argv); }
