#include "apps/viewer/drawn_part.h"

#include <gtest/gtest.h>
#include <imgui.h>

namespace pleinair::drawn_part_test {
namespace {

// A picture of 600x400 points in a window of 1000x800, with a panel beside it.
class DrawnPart : public testing::Test {
 protected:
  DrawnPart() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {1000.0f, 800.0f};
    unsigned char* pixels = nullptr;
    int width = 0;
    int height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  }
  ~DrawnPart() override { ImGui::DestroyContext(); }

  // With a window of 200x100 points there.
  bool IsCutWithWindowAt(float x, float y) {
    bool cuts = false;
    // A window is drawn from its second frame on.
    for (int i = 0; i < 2; ++i) {
      ImGui::NewFrame();
      // Marks over the picture, which may reach out of it.
      ImGui::GetBackgroundDrawList()->AddLine({10.0f, 10.0f}, {900.0f, 700.0f}, 0xffffffff);
      ImGui::SetNextWindowPos({600.0f, 0.0f});
      ImGui::SetNextWindowSize({400.0f, 800.0f});
      ImGui::Begin("panel");
      for (int line = 0; line < 200; ++line) ImGui::Text("line %d", line);
      ImGui::End();
      ImGui::SetNextWindowPos({x, y});
      ImGui::SetNextWindowSize({200.0f, 100.0f});
      ImGui::Begin("help");
      ImGui::TextUnformatted("a text that is longer than the window is wide, and clipped there");
      ImGui::End();
      ImGui::Render();
      cuts = CutsAWindow(*ImGui::GetDrawData(), {0.0, 0.0}, {600.0, 400.0});
    }
    return cuts;
  }
};

TEST_F(DrawnPart, CutsAWindowThatLiesOverItsEdge) {
  EXPECT_TRUE(IsCutWithWindowAt(500.0f, 100.0f));
  EXPECT_TRUE(IsCutWithWindowAt(100.0f, 350.0f));
  EXPECT_FALSE(IsCutWithWindowAt(100.0f, 100.0f));  // Within.
  EXPECT_FALSE(IsCutWithWindowAt(100.0f, 500.0f));  // Beside it.
  EXPECT_FALSE(IsCutWithWindowAt(400.0f, 300.0f));  // Up to the edge.
}

}  // namespace
}  // namespace pleinair::drawn_part_test
