#include "datasets/site_objects.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/mat3x3.hpp>
#include <nlohmann/json.hpp>

#include "datasets/internal/sequence_folder.h"
#include "datasets/internal/sequence_json.h"
#include "datasets/site_file.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool IsPose(const glm::dmat4& pose) {
  const glm::dmat3 linear(pose);
  const double volume = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  return std::isfinite(glm::dot(pose[3], pose[3])) && std::isfinite(volume) &&
         std::abs(glm::determinant(linear)) > 1e-9 * volume;
}

void Require(const fs::path& file, std::span<const VirtualObjectEntry> objects) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string where = fmt::format("virtual_objects[{}]", i);
    const auto inside = ResolveInside(file.parent_path(), objects[i].mesh);
    std::error_code error;
    if (!inside || !fs::is_regular_file(*inside, error)) {
      RefuseFile(
          file,
          where + ".mesh: expected a file in the site's folder, found " + objects[i].mesh.string());
    }
    if (!IsPose(objects[i].world_from_object)) {
      RefuseFile(file, where + ".world_from_object: expected a finite, invertible transform");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (objects[k].mesh == objects[i].mesh &&
          objects[k].world_from_object == objects[i].world_from_object) {
        RefuseFile(
            file,
            fmt::format(
                "{}: expected another mesh or place than virtual_objects[{}] has", where, k));
      }
    }
  }
}

// The known entry of that mesh, preferably at that pose too, which is taken out; none: a new one.
Json TakeKnown(std::vector<Json>& known, const Json& object) {
  const auto is_same_mesh = [&](const Json& entry) {
    return fs::path(entry.at("mesh").get<std::string>()).lexically_normal() ==
           fs::path(object.at("mesh").get<std::string>());
  };
  auto found = std::find_if(known.begin(), known.end(), [&](const Json& entry) {
    return is_same_mesh(entry) && entry.at("world_from_object") == object.at("world_from_object");
  });
  if (found == known.end()) found = std::find_if(known.begin(), known.end(), is_same_mesh);
  if (found == known.end()) return Json::object();
  Json taken = std::move(*found);
  known.erase(found);
  return taken;
}

// The rest of a line behind its first word, without blanks around it; none where that is not
// `word`.
std::optional<std::string> Behind(std::string_view word, const std::string& line) {
  const std::size_t start = line.find_first_not_of(" \t");
  if (start == std::string::npos || line.compare(start, word.size(), word) != 0) {
    return std::nullopt;
  }
  const std::size_t rest = line.find_first_not_of(" \t\r", start + word.size());
  if (rest == std::string::npos || rest == start + word.size()) return std::nullopt;
  return line.substr(rest, line.find_last_not_of(" \t\r") + 1 - rest);
}

// Paths in text: all of it, and each of its words.
std::vector<fs::path> PathsIn(const std::string& text) {
  std::vector<fs::path> paths{text};
  std::istringstream words(text);
  for (std::string word; words >> word;) paths.emplace_back(word);
  return paths;
}

std::string TextOf(const fs::path& file) {
  const std::vector<std::byte> bytes = ReadWholeFile(file);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Names behind the key words of a file of lines.
std::vector<fs::path> NamesInLines(const fs::path& file, std::span<const char* const> words) {
  std::vector<fs::path> names;
  std::istringstream lines(TextOf(file));
  for (std::string line; std::getline(lines, line);) {
    for (const char* word : words) {
      if (const auto rest = Behind(word, line)) {
        for (fs::path& path : PathsIn(*rest)) names.push_back(std::move(path));
      }
    }
  }
  return names;
}

// Decodes a URI: "%20" becomes a blank.
std::string Unescaped(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 2]))) {
      text += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

std::vector<fs::path> NamesInGltf(const fs::path& file) {
  std::vector<fs::path> names;
  const Json document = Json::parse(TextOf(file), nullptr, false);
  if (!document.is_object()) return names;  // Reading the mesh reports it.
  for (const char* list : {"buffers", "images"}) {
    for (const Json& entry : document.value(list, Json::array())) {
      const auto uri = entry.is_object() ? entry.find("uri") : entry.end();
      if (!entry.is_object() || uri == entry.end() || !uri->is_string()) continue;
      const std::string text = uri->get<std::string>();
      if (text.starts_with("data:")) continue;
      names.emplace_back(text);
      names.emplace_back(Unescaped(text));
    }
  }
  return names;
}

// The mesh and the existing files that it names, relative to its folder. Missing ones are reported
// when the mesh is read.
std::set<fs::path> FilesOf(const fs::path& mesh) {
  constexpr const char* kLibrary[] = {"mtllib"};
  constexpr const char* kTexture[] = {"map_Kd"};
  const fs::path folder = mesh.parent_path();
  std::set<fs::path> files{mesh.filename()};
  const auto add = [&](const fs::path& base, const std::vector<fs::path>& names) {
    std::vector<fs::path> added;
    for (const fs::path& name : names) {
      const fs::path relative = (base / name).lexically_normal();
      std::error_code error;
      const auto inside = ResolveInside(folder, relative);
      if (inside && fs::is_regular_file(*inside, error) && files.insert(relative).second) {
        added.push_back(relative);
      }
    }
    return added;
  };
  std::string ending = mesh.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (ending == ".gltf") add("", NamesInGltf(mesh));
  if (ending == ".obj") {
    for (const fs::path& library : add("", NamesInLines(mesh, kLibrary))) {
      add(library.parent_path(), NamesInLines(folder / library, kTexture));
    }
  }
  return files;
}

bool HasSameFiles(const fs::path& copy, const fs::path& folder, const std::set<fs::path>& files) {
  return std::all_of(files.begin(), files.end(), [&](const fs::path& file) {
    std::error_code error;
    if (!fs::is_regular_file(copy / file, error)) return false;
    return ReadWholeFile(copy / file) == ReadWholeFile(folder / file);
  });
}

void CopyFiles(const fs::path& from, const std::set<fs::path>& files, const fs::path& to) {
  WriteWholeFolder(to, [&](const fs::path& folder) {
    for (const fs::path& file : files) {
      fs::create_directories((folder / file).parent_path());
      fs::copy_file(from / file, folder / file);
    }
  });
}

}  // namespace

void SaveObjects(const fs::path& folder, std::span<const VirtualObjectEntry> objects) {
  const fs::path file = SiteFileIn(folder);
  Require(file, objects);
  EditSiteFile(folder, [&](Json& json) {
    std::vector<Json> known;
    if (json.contains("virtual_object")) known.push_back(json["virtual_object"]);
    for (const Json& entry : json.value("virtual_objects", Json::array())) known.push_back(entry);
    Json list = Json::array();
    for (const VirtualObjectEntry& object : objects) {
      const Json values = JsonOf(object);
      Json entry = TakeKnown(known, values);
      for (const auto& [key, value] : values.items()) {
        // A path that is written in another way is the same path, and 1 is 1.0.
        if (!entry.contains(key) || (key != "mesh" && entry[key] != value)) entry[key] = value;
      }
      list.push_back(std::move(entry));
    }
    // A file with the key of a single object keeps it.
    if (json.contains("virtual_object") && list.size() == 1) {
      json["virtual_object"] = list.front();
      return;
    }
    json.erase("virtual_object");
    if (list.empty()) {
      json.erase("virtual_objects");
    } else {
      json["virtual_objects"] = std::move(list);
    }
  });
}

fs::path BringObjectFile(const fs::path& folder, const fs::path& mesh) {
  RequireFile(mesh);
  const fs::path source = fs::canonical(mesh);
  fs::path relative = source.lexically_relative(fs::canonical(folder));
  if (*relative.begin() != "..") return relative;
  const std::set<fs::path> files = FilesOf(source);
  const fs::path objects = "objects";
  const std::string name = source.stem().string();
  for (int number = 1;; ++number) {
    const fs::path place = objects / (number == 1 ? name : fmt::format("{}-{}", name, number));
    std::error_code error;
    if (!fs::exists(folder / place, error)) {
      CopyFiles(source.parent_path(), files, folder / place);
    } else if (!HasSameFiles(folder / place, source.parent_path(), files)) {
      continue;
    }
    return place / source.filename();
  }
}

}  // namespace pleinair
