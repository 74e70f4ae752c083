#include "apps/set_aside.h"

#include <system_error>
#include <utility>

#include "scene/whole_file.h"

namespace pleinair {

SetAside::SetAside(std::filesystem::path folder) : folder_(std::move(folder)) {
  // As an unfinished report: what a killed process left is removed by the next run.
  const std::filesystem::path file = folder_ / ".report.html.pictures.part";
  file_.open(file, std::ios::in | std::ios::out | std::ios::trunc | std::ios::binary);
  if (!file_) RefuseFile(folder_, "a file for the report's pictures cannot be made in it");
  std::error_code error;
  std::filesystem::remove(file, error);
  if (error) RefuseFile(file, "cannot be removed: " + error.message());
}

SetAside::Place SetAside::Add(const std::string& bytes) {
  const Place place{end_, static_cast<std::int64_t>(bytes.size())};
  Write(bytes);
  return place;
}

std::string SetAside::Read(const Place& place) const {
  std::string bytes(static_cast<std::size_t>(place.bytes), '\0');
  file_.seekg(place.offset);
  if (!file_.read(bytes.data(), place.bytes)) {
    RefuseFile(folder_, "the report's pictures cannot be read back");
  }
  return bytes;
}

void SetAside::KeepOnly(std::span<Place* const> places) {
  end_ = 0;
  for (Place* const place : places) *place = Add(Read(*place));
}

void SetAside::Write(const std::string& bytes) {
  file_.seekp(end_);
  if (!file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush()) {
    RefuseFile(folder_, "the report's pictures cannot be written: expected free space");
  }
  end_ += static_cast<std::int64_t>(bytes.size());
}

}  // namespace pleinair
