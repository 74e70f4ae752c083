// A text file that grows by lines, and is complete up to its last line at any moment.
#pragma once

#include <filesystem>
#include <string_view>

namespace pleinair {

// Added lines survive a kill of the process. After Sync they, and everything else written to the
// file system before, survive a power cut.
class LineFile {
 public:
  // A new one. Throws std::runtime_error naming it, as all functions here.
  explicit LineFile(std::filesystem::path file);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  // Adds a line, given without its end: all of it or, where that fails, nothing.
  void Add(std::string_view line);
  // Takes back the last Add.
  void RemoveLast();
  // May be called from another thread; takes as long as the disk needs.
  void Sync() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  long long size_ = 0;
  long long size_before_last_ = 0;
};

}  // namespace pleinair
