// The window's edits of objects, without a window.
#include "apps/viewer/object_editor.h"

#include <numbers>

#include <gmock/gmock.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "apps/site_place_command.h"
#include "calib/lens.h"
#include "datasets/sequence.h"
#include "datasets/site_objects.h"
#include "scene/mesh_io.h"
#include "tests/viewer/coarse_courtyard.h"

namespace pleinair::object_editor_test {
namespace {

namespace fs = std::filesystem;

// On paving, clear of walls; and in the sky.
constexpr glm::dvec2 kGroundPx{200.0, 300.0};
constexpr glm::dvec2 kSkyPx{240.0, 2.0};

class Editor : public testing::Test {
 protected:
  std::vector<glm::dmat4> Poses() const {
    std::vector<glm::dmat4> poses;
    for (const VirtualObjectEntry& object : editor_.Objects()) {
      poses.push_back(object.world_from_object);
    }
    return poses;
  }
  std::vector<glm::dmat4> SavedPoses() const {
    std::vector<glm::dmat4> poses;
    for (const VirtualObjectEntry& object : ReadSequence(copy_.Path()).virtual_objects) {
      poses.push_back(object.world_from_object);
    }
    return poses;
  }
  glm::dvec2 FootPx() const {
    const PlaceableObject object(LoadMesh(copy_ / "object.obj").mesh);
    const glm::dvec3 foot = FootOf(object, Poses()[*editor_.Selected()]);
    return ProjectToPixel(camera_.intrinsics,
                          glm::dvec3(camera_.camera_from_world * glm::dvec4(foot, 1.0)))
        .value();
  }

  CourtyardCopy copy_;
  std::shared_ptr<const ViewedSite> site_ = ViewedSiteOf(copy_.Path());
  Camera camera_ = site_->loaded->sequence.CameraOfFrame(0);
  ObjectEditor editor_{site_};
};

TEST_F(Editor, EachEditIsUndoneAndRedone) {
  const auto first = Poses();
  editor_.Turn(0.5);
  const auto turned = Poses();
  editor_.Lift(0.25);
  const auto lifted = Poses();
  editor_.Scale(1.5);
  const auto scaled = Poses();
  ASSERT_NE(first, turned);
  ASSERT_NE(turned, lifted);
  ASSERT_NE(lifted, scaled);
  for (const auto& poses : {lifted, turned, first}) {
    ASSERT_TRUE(editor_.CanUndo());
    editor_.Undo();
    EXPECT_EQ(Poses(), poses);
  }
  EXPECT_FALSE(editor_.CanUndo());
  const std::int64_t edits = editor_.Edits();
  editor_.Undo();  // There is nothing more.
  EXPECT_EQ(editor_.Edits(), edits);
  for (const auto& poses : {turned, lifted, scaled}) {
    ASSERT_TRUE(editor_.CanRedo());
    editor_.Redo();
    EXPECT_EQ(Poses(), poses);
  }
  EXPECT_FALSE(editor_.CanRedo());
  editor_.Undo();
  editor_.Turn(0.1);  // What was undone cannot come back any more.
  EXPECT_FALSE(editor_.CanRedo());
}

TEST_F(Editor, ADragIsOneEdit) {
  const auto before = Poses();
  editor_.BeginDrag();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(editor_.RestAt(camera_, {200.0 + 5.0 * i, 300.0}), "");
  editor_.EndDrag();
  EXPECT_EQ(editor_.RestAt(camera_, {230.0, 310.0}), "");
  editor_.Undo();
  const auto dragged = Poses();
  EXPECT_NE(dragged, before);
  editor_.Undo();
  EXPECT_EQ(Poses(), before);
  EXPECT_FALSE(editor_.CanUndo());
  editor_.Redo();
  EXPECT_EQ(Poses(), dragged);
}

TEST_F(Editor, ADragThatMovesNothingIsNoEdit) {
  editor_.BeginDrag();
  EXPECT_NE(editor_.RestAt(camera_, kSkyPx), "");
  editor_.EndDrag();
  EXPECT_FALSE(editor_.CanUndo());
  EXPECT_FALSE(editor_.HasUnsavedEdits());
}

TEST_F(Editor, SavesWhatTheCommandWrites) {
  EXPECT_EQ(editor_.RestAt(camera_, kGroundPx), "");
  editor_.Turn(std::numbers::pi / 6.0);
  editor_.Lift(0.25);
  editor_.Scale(1.5);
  editor_.Save();
  const CourtyardCopy commanded;
  SitePlaceOptions options;
  options.folder = commanded.Path();
  options.object = "0";
  options.pixel = {kGroundPx.x, kGroundPx.y};
  RunSitePlace(options);
  options.pixel.clear();
  options.turn_deg = 30.0;
  RunSitePlace(options);
  options.turn_deg = 0.0;
  options.lift_m = 0.25;
  RunSitePlace(options);
  options.lift_m = 0.0;
  options.scale = 1.5;
  RunSitePlace(options);
  const glm::dmat4 expected = ReadSequence(commanded.Path()).virtual_objects[0].world_from_object;
  ASSERT_EQ(SavedPoses().size(), 1u);
  // Rounding of sin and cos: angles are converted on different ways.
  for (int c = 0; c < 4; ++c) {
    EXPECT_LT(glm::distance(SavedPoses()[0][c], expected[c]), 1e-14) << c;
  }
  EXPECT_EQ(SavedPoses(), Poses());
}

TEST_F(Editor, SavesWhatTheCommandWritesBitForBitWhereItIsPut) {
  EXPECT_EQ(editor_.RestAt(camera_, kGroundPx), "");
  editor_.Save();
  const CourtyardCopy commanded;
  SitePlaceOptions options;
  options.folder = commanded.Path();
  options.object = "0";
  options.pixel = {kGroundPx.x, kGroundPx.y};
  RunSitePlace(options);
  EXPECT_EQ(ContentOf(copy_ / "sequence.json"), ContentOf(commanded / "sequence.json"));
}

TEST_F(Editor, UnsavedIsWhatDiffersFromTheFile) {
  EXPECT_FALSE(editor_.HasUnsavedEdits());
  editor_.Turn(0.5);
  EXPECT_TRUE(editor_.HasUnsavedEdits());
  editor_.Undo();
  EXPECT_FALSE(editor_.HasUnsavedEdits());
  editor_.Redo();
  editor_.Save();
  EXPECT_FALSE(editor_.HasUnsavedEdits());
  editor_.Undo();
  EXPECT_TRUE(editor_.HasUnsavedEdits());
  editor_.Turn(0.25);  // Another state of as many edits.
  EXPECT_TRUE(editor_.HasUnsavedEdits());
  editor_.Select(0);  // A selection is no edit.
  editor_.Save();
  editor_.Select(std::nullopt);
  EXPECT_FALSE(editor_.HasUnsavedEdits());
}

TEST_F(Editor, ADuplicateStandsBesideItsOriginal) {
  editor_.Turn(0.7);
  editor_.Duplicate();
  ASSERT_EQ(editor_.Objects().size(), 2u);
  EXPECT_EQ(editor_.Selected(), 1u);
  const glm::dmat4 from = Poses()[0];
  const glm::dmat4 to = Poses()[1];
  // Turned alike, and apart along the object's own X axis by more than it is wide.
  EXPECT_EQ(glm::dmat3(from), glm::dmat3(to));
  const auto original = editor_.BoxOf(0);
  const auto copy = editor_.BoxOf(1);
  const glm::dvec3 along = glm::normalize(glm::dvec3(from[0]));
  double original_end = -1e9;
  double copy_start = 1e9;
  for (std::size_t i = 0; i < original.size(); ++i) {
    original_end = std::max(original_end, glm::dot(original[i], along));
    copy_start = std::min(copy_start, glm::dot(copy[i], along));
  }
  EXPECT_GT(copy_start, original_end);
  EXPECT_NEAR(from[3].z, to[3].z, 1e-12);
  editor_.Save();
  EXPECT_EQ(SavedPoses(), Poses());
}

TEST_F(Editor, WhatIsDeletedIsOutOfTheFile) {
  editor_.Duplicate();
  editor_.Duplicate();
  const auto three = Poses();
  editor_.Select(1);
  editor_.Delete();
  EXPECT_EQ(editor_.Selected(), 1u);
  EXPECT_THAT(Poses(), testing::ElementsAre(three[0], three[2]));
  editor_.Delete();
  EXPECT_EQ(editor_.Selected(), 0u);
  editor_.Delete();
  EXPECT_FALSE(editor_.Selected());
  editor_.Save();
  EXPECT_TRUE(SavedPoses().empty());
  // Without an object nothing happens, and nothing is an edit.
  const std::int64_t edits = editor_.Edits();
  editor_.Turn(1.0);
  editor_.Lift(1.0);
  editor_.Scale(2.0);
  editor_.Delete();
  editor_.Duplicate();
  editor_.SelectNext(1);
  EXPECT_EQ(editor_.RestAt(camera_, kGroundPx), "");
  EXPECT_EQ(editor_.Nudge(camera_, {1.0, 0.0}), "");
  EXPECT_EQ(editor_.Edits(), edits);
  editor_.Undo();
  editor_.Undo();
  editor_.Undo();
  EXPECT_EQ(Poses(), three);
  editor_.Save();
  EXPECT_EQ(SavedPoses(), three);
}

TEST_F(Editor, SelectionGoesAroundTheList) {
  editor_.Duplicate();
  editor_.Duplicate();
  for (const std::size_t expected : {0u, 1u, 2u, 0u}) {
    editor_.SelectNext(1);
    EXPECT_EQ(editor_.Selected(), expected);
  }
  editor_.SelectNext(-1);
  EXPECT_EQ(editor_.Selected(), 2u);
  editor_.Select(std::nullopt);
  editor_.SelectNext(-1);
  EXPECT_EQ(editor_.Selected(), 2u);
  editor_.Select(std::nullopt);
  editor_.SelectNext(1);
  EXPECT_EQ(editor_.Selected(), 0u);
}

TEST_F(Editor, AnObjectIsFoundWhereItIsInSightAlone) {
  ASSERT_EQ(editor_.RestAt(camera_, kGroundPx), "");
  const glm::dvec2 above = kGroundPx - glm::dvec2(0.0, 6.0);
  EXPECT_EQ(editor_.ObjectAt(camera_, above), 0u);
  EXPECT_FALSE(editor_.ObjectAt(camera_, kSkyPx));
  EXPECT_FALSE(editor_.ObjectAt(camera_, {20.0, 340.0}));
  // Farther away along the same line of sight than every wall, and larger in proportion.
  const glm::dvec3 centre = camera_.CentreWorldM();
  const glm::dmat4 away = glm::translate(glm::dmat4(1.0), centre) *
                          glm::scale(glm::dmat4(1.0), glm::dvec3(20.0)) *
                          glm::translate(glm::dmat4(1.0), -centre);
  std::vector<VirtualObjectEntry> objects = editor_.Objects();
  objects[0].world_from_object = away * Poses()[0];
  SaveObjects(copy_.Path(), objects);
  const ObjectEditor far_away(ViewedSiteOf(copy_.Path()));
  EXPECT_FALSE(far_away.ObjectAt(camera_, above));
}

// What pixels show in front is found, not what is first in the list.
TEST_F(Editor, OfTwoObjectsTheNearerOneIsFound) {
  ASSERT_EQ(editor_.RestAt(camera_, kGroundPx), "");
  editor_.Duplicate();
  ASSERT_EQ(editor_.RestAt(camera_, kGroundPx + glm::dvec2(0.0, 12.0)), "");
  EXPECT_EQ(editor_.ObjectAt(camera_, kGroundPx), 1u);
}

TEST_F(Editor, ANudgeMovesTheFootByPixels) {
  ASSERT_EQ(editor_.RestAt(camera_, kGroundPx), "");
  for (const glm::dvec2 step : {glm::dvec2(1.0, 0.0),
                                glm::dvec2(0.0, -1.0),
                                glm::dvec2(-10.0, 0.0),
                                glm::dvec2(0.0, 10.0)}) {
    const glm::dvec2 before = FootPx();
    EXPECT_EQ(editor_.Nudge(camera_, step), "");
    // 0.1 mm off the ground is less than 0.01 pixels from 4 m away on.
    EXPECT_LT(glm::distance(FootPx(), before + step), 0.02);
  }
}

TEST_F(Editor, AFileFromElsewhereIsBroughtToTheSite) {
  const TemporaryFolder elsewhere;
  fs::copy_file(copy_ / "object.obj", elsewhere / "statue.obj");
  fs::copy_file(copy_ / "object.mtl", elsewhere / "object.mtl");
  EXPECT_EQ(editor_.Add(elsewhere / "statue.obj", camera_, kGroundPx), "");
  ASSERT_EQ(editor_.Objects().size(), 2u);
  EXPECT_EQ(editor_.Selected(), 1u);
  // Nothing is copied before it is saved; then as often as it is saved once.
  EXPECT_FALSE(fs::exists(copy_ / "objects"));
  editor_.Save();
  editor_.Turn(0.5);
  editor_.Save();
  const Sequence saved = ReadSequence(copy_.Path());
  ASSERT_EQ(saved.virtual_objects.size(), 2u);
  EXPECT_EQ(saved.virtual_objects[1].mesh, "objects/statue/statue.obj");
  EXPECT_FALSE(fs::exists(copy_ / "objects/statue-2"));
  editor_.Undo();
  editor_.Undo();
  EXPECT_EQ(editor_.Objects().size(), 1u);
}

TEST_F(Editor, AnObjectThatFindsNoPlaceLeavesAllAsItWas) {
  editor_.Turn(0.5);
  editor_.Save();
  editor_.Lift(0.5);
  editor_.Undo();
  const auto poses = Poses();
  EXPECT_NE(editor_.Add(copy_ / "object.obj", camera_, kSkyPx), "");
  EXPECT_NE(MessageOf([&] { editor_.Add(copy_ / "none.obj", camera_, kGroundPx); }), "");
  EXPECT_EQ(Poses(), poses);
  EXPECT_EQ(editor_.Selected(), 0u);
  EXPECT_FALSE(editor_.HasUnsavedEdits());
  EXPECT_TRUE(editor_.CanUndo());
  ASSERT_TRUE(editor_.CanRedo());
  editor_.Redo();
  EXPECT_NE(Poses(), poses);
}

TEST_F(Editor, WhatCannotBeSavedStaysUnsaved) {
  editor_.Turn(0.5);
  const auto poses = Poses();
  const std::string whole = ContentOf(copy_ / "sequence.json");
  std::ofstream(copy_ / "sequence.json") << whole.substr(0, 100);
  const std::string message = MessageOf([&] { editor_.Save(); });
  EXPECT_THAT(message, testing::HasSubstr("sequence.json"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_EQ(ContentOf(copy_ / "sequence.json"), whole.substr(0, 100));
  EXPECT_TRUE(editor_.HasUnsavedEdits());
  std::ofstream(copy_ / "sequence.json") << whole;
  editor_.Save();
  EXPECT_EQ(SavedPoses(), poses);
  EXPECT_FALSE(editor_.HasUnsavedEdits());
}

}  // namespace
}  // namespace pleinair::object_editor_test
