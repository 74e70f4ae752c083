// The files of a site, without recordings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "datasets/sequence.h"

namespace pleinair {

// Paths relative to `site.folder` of everything in it but: sequence.json and site.json; pictures
// and lists of frames; `truth`; hidden files; other recordings and results of runs (folders with a
// sequence.json, site.json or lighting.jsonl of their own); and `left_out`, which may lie in it.
//
// All files are taken, not only those that sequence.json names, because meshes and materials name
// further files. Links that lead out of the folder are left out.
std::vector<std::filesystem::path> SiteFiles(const std::filesystem::path& folder,
                                             const std::filesystem::path& left_out);

// Returns the bytes of these files together.
std::uint64_t SizeOf(const std::filesystem::path& folder,
                     const std::vector<std::filesystem::path>& files);

}  // namespace pleinair
