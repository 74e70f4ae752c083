#include "scene/whole_file.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include <unistd.h>

namespace pleinair {

void RefuseFile(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

void RequireFile(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    throw std::runtime_error(file.string() + ": no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw std::runtime_error(file.string() + ": not a regular file");
  }
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw std::runtime_error(file.string() + ": cannot be read: " + error.message());
  if (size == 0) throw std::runtime_error(file.string() + ": the file is empty");
}

std::vector<std::byte> ReadWholeFile(const std::filesystem::path& file) {
  RequireFile(file);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw std::runtime_error(file.string() + ": cannot be read: " + error.message());
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  std::ifstream stream(file, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!stream) {
    throw std::runtime_error(file.string() + ": cannot be read: " + std::strerror(errno));
  }
  return bytes;
}

void RequireReplaceable(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return;
  RefuseFile(file,
             std::string("cannot be written: expected a regular file there, or none, found ") +
                 (std::filesystem::is_directory(status) ? "a folder" : "a device or a pipe"));
}

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const std::string why = error ? error.message() : "found something else";
  if (!std::filesystem::is_directory(folder, error)) {
    RefuseFile(folder, "expected a folder, or room for one: " + why);
  }
}

void WriteWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  RequireReplaceable(file);
  // Two threads or processes may write the same file at once: the last rename wins, with a complete
  // file.
  static std::atomic<unsigned> counter{0};
  std::string name(".");
  name += file.filename().string() + "." + std::to_string(getpid()) + "." +
          std::to_string(counter++) + ".part";
  const std::filesystem::path temporary = file.parent_path() / name;
  std::string failure;
  {
    errno = 0;
    std::ofstream stream(temporary, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) failure = errno != 0 ? std::strerror(errno) : "write error";
  }
  std::error_code error;
  if (failure.empty()) {
    std::filesystem::rename(temporary, file, error);
    if (!error) return;
    failure = error.message();
  }
  std::filesystem::remove(temporary, error);
  throw std::runtime_error(file.string() + ": cannot be written: " + failure);
}

void WriteWholeText(const std::filesystem::path& file, const std::string& text) {
  WriteWholeFile(file, std::as_bytes(std::span(text)));
}

void WriteWholeFolder(const std::filesystem::path& folder,
                      const std::function<void(const std::filesystem::path&)>& fill) {
  std::error_code error;
  // Without links and a slash at the end, which rename would not follow.
  std::filesystem::path target = std::filesystem::weakly_canonical(folder, error);
  if (error) RefuseFile(folder, "cannot be written: " + error.message());
  if (!target.has_filename()) target = target.parent_path();
  std::string name(".");
  name += target.filename().string() + "." + std::to_string(getpid()) + ".part";
  const std::filesystem::path temporary = target.parent_path() / name;
  try {
    std::filesystem::remove_all(temporary);
    std::filesystem::create_directories(temporary);
    fill(temporary);
    std::filesystem::rename(temporary, target);
  } catch (const std::filesystem::filesystem_error& failure) {
    std::filesystem::remove_all(temporary, error);
    RefuseFile(folder, "cannot be written: " + failure.code().message());
  } catch (...) {
    std::filesystem::remove_all(temporary, error);
    throw;
  }
}

}  // namespace pleinair
