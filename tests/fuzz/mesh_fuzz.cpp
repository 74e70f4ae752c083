// Meshes of the format that the name of the file, a definition of the target, ends with.
#include "scene/mesh_io.h"

#include <cmath>

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  static const auto obj =
      folder.Write("of_material.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  auto file = FuzzFile(PLEINAIR_FUZZ_FILE, data, size, folder);
  if (file.extension() == ".mtl") file = obj;
  return pleinair::ReadsOrRefuses([&] {
    const pleinair::LoadedParts loaded =
        pleinair::LoadMeshParts(file, pleinair::MeshColours::kByPlace);
    for (const pleinair::MeshPart& part : loaded.parts) {
      for (const glm::vec3& p : part.mesh.positions_m) {
        if (!std::isfinite(p.x + p.y + p.z)) std::abort();
      }
      for (const glm::uvec3& t : part.mesh.triangles) {
        for (int c = 0; c < 3; ++c) {
          if (t[c] >= part.mesh.positions_m.size()) std::abort();
        }
      }
    }
  });
}
