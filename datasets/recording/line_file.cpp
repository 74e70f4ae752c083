#include "datasets/recording/line_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "scene/whole_file.h"

namespace pleinair {

LineFile::LineFile(std::filesystem::path file) : file_(std::move(file)) {
  descriptor_ = open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) RefuseFile(file_, std::string("cannot be made: ") + std::strerror(errno));
}

LineFile::~LineFile() { close(descriptor_); }

void LineFile::Add(std::string_view line) {
  std::string text(line);
  text += '\n';
  const ssize_t written = pwrite(descriptor_, text.data(), text.size(), size_);
  if (written == static_cast<ssize_t>(text.size())) {
    size_before_last_ = std::exchange(size_, size_ + written);
    return;
  }
  const int error = written < 0 ? errno : ENOSPC;
  // Half a line would spoil the next one; where it stays, readers pass over it as the last.
  [[maybe_unused]] const int cut = ftruncate(descriptor_, size_);
  RefuseFile(file_, std::string("cannot be written: ") + std::strerror(error));
}

void LineFile::RemoveLast() {
  size_ = size_before_last_;
  if (ftruncate(descriptor_, size_) == 0) return;
  RefuseFile(file_, std::string("cannot be cut: ") + std::strerror(errno));
}

void LineFile::Sync() const {
  if (syncfs(descriptor_) == 0) return;
  RefuseFile(file_, std::string("cannot be kept on the disk: ") + std::strerror(errno));
}

}  // namespace pleinair
