// Real photographs: the shadow of an arch falls where the computed sun puts it.

#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "pipeline/shadow_edge_marks.h"
#include "pipeline/sun_state.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"

namespace pleinair::shadow_edge_marks_recorded_test {
namespace {

TEST(ShadowEdgeMarksOfPhotographs, BerlinsArchCastsItsShadowWhereTheSunPutsIt) {
  const std::filesystem::path folder = PLEINAIR_SHARED_DIR "/sequences/berlin-photos";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "berlin-photos is not here";
  const Sequence sequence = ReadSequence(folder);
  const RayCaster mesh(LoadMesh(folder / sequence.scene_mesh).mesh);
  const auto source = MakeRecordedFrameSource(sequence, FrameKind::kLdr);
  std::vector<ShadowEdgeMark> marks;
  for (int index = 0; const auto frame = source->Next(); ++index) {
    ASSERT_TRUE(frame->has_value()) << frame->error().reason;
    if (index != 2) continue;
    // By eye, on the flat parts of the back wall.
    for (const glm::dvec2& pixel : {glm::dvec2(286, 545.5),
                                    glm::dvec2(293, 541.5),
                                    glm::dvec2(328, 514.5),
                                    glm::dvec2(340, 509),
                                    glm::dvec2(352, 505),
                                    glm::dvec2(380, 501.5)}) {
      const glm::dvec3 sun = SunOfFrame(sequence.site, **frame).direction_enu;
      marks.push_back({(*frame)->camera, pixel, sun});
    }
  }
  const ShadowEdgeFit fit = FitShadowEdges(mesh, marks);
  EXPECT_EQ(fit.used, marks.size());
  // Two pixels of the mark are 0.2 deg of the sun there, the mesh's arch is off by as much.
  EXPECT_LE(DegFromRad(fit.rms_rad), 0.5);
}

}  // namespace
}  // namespace pleinair::shadow_edge_marks_recorded_test
