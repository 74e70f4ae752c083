// A recorded sequence as it would be with a finer mesh of its site, a finer object or larger
// pictures, for scripts/measure-growth.
//
//   pleinair_grown_sequence SEQUENCE OUT [--triangles=N] [--photogrammetry] [--faces=N]
//   [--size=WxH]
//                           [--frame=N] [--frames=N] [--walk]
//
// OUT, which must not exist, becomes a sequence. Its frames repeat one frame of SEQUENCE, a second
// apart. With --walk they are a thirtieth of a second apart, from a camera that moves by a
// centimetre and a milliradian a frame, back and forth.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "bench/cut_mesh.h"
#include "bench/grown_mesh.h"
#include "bench/resized_frame.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "scene/mesh_writer.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

struct Growth {
  std::optional<std::size_t> triangles;
  bool photogrammetry = false;
  std::optional<std::size_t> faces;
  std::optional<std::pair<int, int>> size_px;
  int frame = 0;  // The source's frame that is repeated.
  int frames = 6;
  bool walk = false;
};

void Copy(const fs::path& from, const fs::path& to) {
  fs::create_directories(to.parent_path());
  fs::copy_file(from, to);
}

// A copy of the mesh with so many triangles, or of its file where the number stays.
void GrowSite(const Growth& growth, const fs::path& out, Sequence& sequence) {
  Mesh mesh = LoadMesh(sequence.folder / sequence.scene_mesh).mesh;
  // The place that is photographed most: where the virtual object is to stand.
  const glm::dvec3 focus_m(sequence.virtual_objects.at(0).world_from_object[3]);
  Mesh grown = growth.triangles ? Grown(mesh, focus_m, *growth.triangles) : mesh;
  if (growth.photogrammetry) {
    grown = AsFromPhotographs(mesh, std::move(grown), focus_m, PhotogrammetryFaults{});
  }
  sequence.scene_mesh = "scene.obj";
  WriteObj(grown, out / sequence.scene_mesh);
}

void GrowObjects(const Growth& growth, const fs::path& out, Sequence& sequence) {
  for (std::size_t i = 0; i < sequence.virtual_objects.size(); ++i) {
    VirtualObjectEntry& object = sequence.virtual_objects[i];
    Mesh mesh = LoadMesh(sequence.folder / object.mesh).mesh;
    if (growth.faces) mesh = WithTriangles(std::move(mesh), *growth.faces);
    object.mesh = fmt::format("object_{}.obj", i);
    WriteObj(mesh, out / object.mesh);
  }
}

void GrowFrames(const Growth& growth, const fs::path& out, Sequence& sequence) {
  const auto shown = static_cast<std::size_t>(growth.frame);
  if (shown >= sequence.frames.size() || !sequence.frames[shown].image) {
    throw std::runtime_error(fmt::format(
        "{}: frames[{}].image: expected a linear picture", sequence.file.string(), shown));
  }
  FrameEntry entry = sequence.frames[shown];
  Frame frame;
  frame.camera = sequence.CameraOfFrame(shown);
  frame.radiance = ReadRadianceImage(sequence.folder / *entry.image);
  if (growth.size_px) Resize(growth.size_px->first, growth.size_px->second, frame);
  sequence.intrinsics = frame.camera.intrinsics;
  entry.image = "frame.exr";
  entry.image_ldr.reset();
  entry.fisheye.reset();
  WriteExr(out / *entry.image, frame.radiance, ExrPrecision::kHalf);
  sequence.frames.clear();
  for (int i = 0; i < growth.frames; ++i) {
    constexpr int kSteps = 50;
    const int step = kSteps - std::abs((i + kSteps) % (2 * kSteps) - kSteps);
    if (growth.walk) {
      entry.camera_from_world =
          glm::translate(glm::dmat4(1.0), glm::dvec3(-0.01 * step, 0.0, 0.0)) *
          glm::rotate(glm::dmat4(1.0), 1e-3 * step, glm::dvec3(0.0, 1.0, 0.0)) *
          frame.camera.camera_from_world;
    }
    sequence.frames.push_back(entry);
    entry.time += growth.walk ? std::chrono::milliseconds(33) : std::chrono::milliseconds(1000);
  }
}

void Write(const fs::path& source, const fs::path& out, const Growth& growth) {
  Sequence sequence = ReadSequence(source);
  if (fs::exists(out)) throw std::runtime_error(out.string() + ": expected a folder to be made");
  fs::create_directories(out);
  GrowSite(growth, out, sequence);
  GrowObjects(growth, out, sequence);
  GrowFrames(growth, out, sequence);
  if (sequence.environment) {
    Copy(sequence.folder / sequence.environment->image, out / sequence.environment->image);
  }
  sequence.diffuse_mask.reset();
  sequence.fisheye.reset();
  WriteSequence(sequence, out);
}

int Number(std::string_view argument, std::string_view text, int least = 1) {
  const std::string digits(text);
  std::size_t used = 0;
  const int number = digits.empty() ? 0 : std::stoi(digits, &used);
  if (number < least || used != digits.size()) {
    throw std::invalid_argument(std::string(argument) + ": expected a number of " +
                                std::to_string(least) + " or more");
  }
  return number;
}

Growth GrowthOf(int count, char** arguments) {
  Growth growth;
  for (int i = 0; i < count; ++i) {
    const std::string_view argument = arguments[i];
    const std::string_view value =
        argument.substr(std::min(argument.find('='), argument.size() - 1) + 1);
    if (argument == "--photogrammetry") {
      growth.photogrammetry = true;
    } else if (argument == "--walk") {
      growth.walk = true;
    } else if (argument.starts_with("--triangles=")) {
      growth.triangles = Number(argument, value);
    } else if (argument.starts_with("--faces=")) {
      growth.faces = Number(argument, value);
    } else if (argument.starts_with("--frame=")) {
      growth.frame = Number(argument, value, 0);
    } else if (argument.starts_with("--frames=")) {
      growth.frames = Number(argument, value);
    } else if (argument.starts_with("--size=")) {
      const std::size_t x = std::min(value.find('x'), value.size());
      growth.size_px = {Number(argument, value.substr(0, x)),
                        Number(argument, value.substr(std::min(x + 1, value.size())))};
    } else {
      throw std::invalid_argument(std::string(argument) + ": not an option of this program");
    }
  }
  return growth;
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  try {
    if (argc < 3) throw std::invalid_argument("expected SEQUENCE OUT [--triangles=N] ...");
    pleinair::Write(argv[1], argv[2], pleinair::GrowthOf(argc - 3, argv + 3));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pleinair_grown_sequence: %s\n", error.what());
    return 2;
  }
  return 0;
}
