#include "datasets/recording/site_files.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "datasets/internal/sequence_folder.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

// Files of a recording, not of the place.
constexpr std::array kOfARecording = {
    "sequence.json", "site.json", "frames.jsonl", "events.jsonl", "judged.json", "truth"};

std::set<fs::path> PicturesOf(const fs::path& folder) {
  std::set<fs::path> pictures;
  if (fs::exists(folder / "site.json")) return pictures;
  for (const FrameEntry& frame : ReadSequence(folder, SequencePoses::kMayBeAbsent).frames) {
    for (const auto& picture : {frame.image, frame.image_ldr, frame.fisheye}) {
      if (picture) pictures.insert(*picture);
    }
    if (frame.raw) pictures.insert(frame.raw->image);
  }
  return pictures;
}

bool HoldsOwnResults(const fs::path& folder) {
  return std::ranges::any_of(std::array{"sequence.json", "site.json", "lighting.jsonl"},
                             [&](const char* name) { return fs::exists(folder / name); });
}

}  // namespace

std::vector<fs::path> SiteFiles(const fs::path& folder, const fs::path& left_out) {
  const std::set<fs::path> pictures = PicturesOf(folder);
  std::vector<fs::path> files;
  for (auto entry = fs::recursive_directory_iterator(folder);
       entry != fs::recursive_directory_iterator();
       ++entry) {
    const fs::path relative = entry->path().lexically_relative(folder);
    const std::string name = relative.filename().string();
    const bool is_top = relative == relative.filename();
    std::error_code error;
    if (name.starts_with(".") ||
        (is_top && std::ranges::find(kOfARecording, name) != kOfARecording.end()) ||
        (entry->is_directory() &&
         (fs::equivalent(entry->path(), left_out, error) || HoldsOwnResults(entry->path())))) {
      entry.disable_recursion_pending();
      continue;
    }
    if (!entry->is_regular_file() || pictures.contains(relative)) continue;
    if (ResolveInside(folder, relative)) files.push_back(relative);
  }
  std::ranges::sort(files);
  return files;
}

std::uint64_t SizeOf(const fs::path& folder, const std::vector<fs::path>& files) {
  std::uint64_t bytes = 0;
  for (const fs::path& file : files) bytes += fs::file_size(folder / file);
  return bytes;
}

}  // namespace pleinair
