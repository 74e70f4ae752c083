// What the descriptions of commands' arguments share.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "datasets/frame_source.h"

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace pleinair {

// The work that the command line asks for, done after it is read; returns the exit code.
using Work = std::function<int()>;

// Prints to standard output, as OutputText, ending with a new line; returns 0.
int Print(const std::string& text);
// Prints to standard error why the program ends as it does, as MessageText.
void PrintError(const std::string& reason);

// A finite number above 0.
CLI::Validator Positive();
// A finite number of at least 0.
CLI::Validator NotNegative();

// An integer from 0 to 2^64 - 1.
CLI::Validator WholeNumber();

// --bounces
void AddBounces(CLI::App& command, int& bounces);
// --ground-albedo
void AddGroundAlbedo(CLI::App& command, double& albedo);
// --frames
CLI::Option* AddFrames(CLI::App& command, FrameKind& frames);
// --cache
CLI::Option* AddCache(CLI::App& command, std::filesystem::path& cache);

}  // namespace pleinair
