#include "datasets/internal/sequence_file.h"

#include <set>
#include <string>
#include <system_error>

#include "datasets/internal/sequence_folder.h"
#include "scene/image_io.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

bool LooksLikeFrames(const fs::path& file) {
  const std::string content = DescribeContent(file);
  return content.find("picture") != std::string::npos || content.ends_with("video");
}

// The first file of a folder, by name, that is a picture or a video; empty where there is none.
fs::path PictureIn(const fs::path& folder) {
  constexpr int kFilesLookedAt = 1000;
  std::set<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file(error) && entry.file_size(error) > 0) files.insert(entry.path());
    if (files.size() == kFilesLookedAt) break;
  }
  for (const fs::path& file : files) {
    if (LooksLikeFrames(file)) return file;
  }
  return {};
}

}  // namespace

fs::path SequenceFileIn(const fs::path& folder) {
  static const std::string kWhatItIs =
      "a sequence is a folder with frames and a sequence.json that names camera, mesh and each "
      "frame's time (see docs/sequences.md)";
  static const std::string kWithSite =
      "; `pleinair run INPUT --site SITE` takes a video, a picture or a folder of pictures at a "
      "site, which `pleinair site new` makes";
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    const std::string expected = folder.string() + ": expected a sequence's folder, found ";
    if (!fs::is_regular_file(folder, error) || fs::file_size(folder, error) == 0) {
      throw JsonError(expected + (fs::exists(folder, error) ? "something else" : "nothing"));
    }
    const std::string content = DescribeContent(folder);
    if (content.ends_with("video")) {
      throw JsonError(expected + content + ": " + kWhatItIs + kWithSite);
    }
    if (folder.filename() == "sequence.json" || folder.filename() == "site.json")
      throw JsonError(expected + "the file in it");
    throw JsonError(expected + content + ": " + kWhatItIs);
  }
  fs::path file = folder / "sequence.json";
  if (!fs::exists(file, error)) {
    for (const char* still : {"panorama.json", "relight.json"}) {
      if (!fs::exists(folder / still, error)) continue;
      throw JsonError((folder / still).string() +
                      ": expected a sequence (sequence.json), found a still, which this version "
                      "does not handle");
    }
    if (const fs::path picture = PictureIn(folder); !picture.empty()) {
      throw JsonError(file.string() + ": expected a JSON file, found nothing but files such as " +
                      picture.filename().string() + " (" + DescribeContent(picture) +
                      "): " + kWhatItIs + kWithSite);
    }
  }
  if (!ResolveInside(folder, "sequence.json")) {
    throw JsonError(file.string() + ": expected a file inside the sequence's folder");
  }
  return file;
}

void CheckFormat(const JsonCursor& root) {
  if (!root.Value().is_object()) root.Fail("an object");
  const auto format = root.Optional("format");
  if (!format) return;
  if (format->Value() == "pleinair-panorama" || format->Value() == "pleinair-relight") {
    format->Fail("\"pleinair-sequence\" (stills are not handled by this version)");
  }
  format->OneOf({"pleinair-sequence", "pleinair-site"});
}

}  // namespace pleinair
