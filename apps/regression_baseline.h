// A stored baseline of `pleinair regress`: the figures of sequences, and how they were measured.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "apps/sequence_figures.h"

namespace pleinair {

struct SequenceBaseline {
  FigureSettings settings;
  SeededFigures figures;
};

// By the name of the sequence's folder.
using RegressionBaseline = std::map<std::string, SequenceBaseline>;

// Throws std::runtime_error naming file, key and what was expected.
RegressionBaseline ReadRegressionBaseline(const std::filesystem::path& file);

// Written completely or not at all. Throws std::runtime_error naming the file.
void WriteRegressionBaseline(const RegressionBaseline& baseline, const std::filesystem::path& file);

}  // namespace pleinair
