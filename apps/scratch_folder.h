// A folder for what is needed for a while.
#pragma once

#include <filesystem>

namespace pleinair {

// Made among the system's temporary files, and removed with the scope.
class ScratchFolder {
 public:
  // Throws std::runtime_error where none can be made.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& Path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace pleinair
