#include "datasets/internal/sequence_folder.h"

#include <algorithm>
#include <string>

namespace pleinair {

tl::expected<std::filesystem::path, std::string> ResolveInside(
    const std::filesystem::path& folder, const std::filesystem::path& relative) {
  namespace fs = std::filesystem;
  const auto refused = tl::make_unexpected(std::string("a path inside the sequence's folder"));
  if (relative.empty() || relative.is_absolute() ||
      relative.native().find('\0') != std::string::npos) {
    return refused;
  }
  const fs::path normal = relative.lexically_normal();
  if (normal == "." || *normal.begin() == "..") return refused;

  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (error) return refused;
  const fs::path target = fs::weakly_canonical(root / normal, error);
  if (error) return refused;
  const auto [root_end, target_at] =
      std::mismatch(root.begin(), root.end(), target.begin(), target.end());
  if (root_end != root.end()) return refused;
  return folder / normal;
}

std::filesystem::path FileInside(const std::filesystem::path& folder,
                                 const std::filesystem::path& relative) {
  const auto file = ResolveInside(folder, relative);
  if (!file) throw std::runtime_error((folder / relative).string() + ": expected " + file.error());
  std::error_code error;
  if (!std::filesystem::is_regular_file(*file, error)) {
    const bool exists = std::filesystem::exists(*file, error);
    throw std::runtime_error(file->string() + ": expected an image file, found " +
                             (exists ? "something that is no file" : "nothing"));
  }
  return *file;
}

}  // namespace pleinair
