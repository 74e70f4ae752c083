#include "apps/set_aside.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <system_error>
#include <utility>

#include "scene/whole_file.h"

namespace pleinair {
namespace {

// A report of any length without pictures is smaller.
constexpr std::uint64_t kHeldBytes = 2'000'000;

// Returns whether all bytes were transferred. `transfer`: pread or pwrite.
template <typename Transfer, typename Byte>
bool Complete(Transfer transfer, int file, std::span<Byte> bytes, off_t offset) {
  while (!bytes.empty()) {
    const ssize_t count = transfer(file, bytes.data(), bytes.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += count;
  }
  return true;
}

}  // namespace

SetAside::SetAside(std::filesystem::path folder, std::uint64_t keep_free_bytes)
    : folder_(std::move(folder)), keep_free_bytes_(keep_free_bytes) {
  // As an unfinished report: what a killed process left is removed by the next run.
  const std::filesystem::path file = folder_ / ".report.html.pictures.part";
  file_ = Descriptor(open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file_.Number() < 0) {
    RefuseFile(folder_, "a file for the report's pictures cannot be made in it");
  }
  std::error_code error;
  std::filesystem::remove(file, error);
  if (error) RefuseFile(file, "cannot be removed: " + error.message());
  Hold();
}

SetAside::Place SetAside::Add(const std::string& bytes) {
  if (!is_in_memory_ && !HasRoom(bytes.size())) MoveToMemory();
  const Place place{end_, static_cast<std::int64_t>(bytes.size())};
  Write(bytes);
  return place;
}

std::string SetAside::Read(const Place& place) const {
  const auto offset = static_cast<std::size_t>(place.offset);
  const auto count = static_cast<std::size_t>(place.bytes);
  if (is_in_memory_) return memory_.substr(offset, count);
  std::string bytes(count, '\0');
  if (!Complete(pread, file_.Number(), std::span(bytes), place.offset)) {
    RefuseFile(folder_, "the report's pictures cannot be read back");
  }
  return bytes;
}

void SetAside::KeepOnly(std::span<Place* const> places) {
  end_ = 0;
  for (Place* const place : places) {
    const std::string bytes = Read(*place);
    *place = {end_, place->bytes};
    Write(bytes);
  }
}

void SetAside::LeaveRoom() {
  if (HasRoom(0)) return;
  if (!is_in_memory_) MoveToMemory();
  file_ = Descriptor();
}

bool SetAside::HasRoom(std::uint64_t bytes) const {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder_, error);
  return error || space.available >= keep_free_bytes_ + bytes;
}

void SetAside::Hold() const {
  // A small disk is the run's.
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder_, error);
  if (error || space.available < 4 * kHeldBytes) return;
  if (posix_fallocate(file_.Number(), 0, kHeldBytes) == 0) return;
  [[maybe_unused]] const int cut = ftruncate(file_.Number(), 0);
}

void SetAside::MoveToMemory() {
  // Beyond end_, too, where KeepOnly is under way.
  const off_t size = std::max<off_t>(lseek(file_.Number(), 0, SEEK_END), 0);
  memory_ = Read({0, size});
  is_in_memory_ = true;
  [[maybe_unused]] const int cut = ftruncate(file_.Number(), std::min<off_t>(size, kHeldBytes));
}

void SetAside::Write(const std::string& bytes) {
  if (!is_in_memory_ &&
      !Complete(pwrite, file_.Number(), std::span(bytes.data(), bytes.size()), end_)) {
    MoveToMemory();
  }
  if (is_in_memory_) memory_.replace(static_cast<std::size_t>(end_), bytes.size(), bytes);
  end_ += static_cast<std::int64_t>(bytes.size());
}

}  // namespace pleinair
