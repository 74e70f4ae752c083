#include "apps/calibrate_lens_command.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/fisheye_file.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"
#include "tests/calib/drawn_boards.h"
#include "tests/session/command_folder.h"

namespace pleinair::calibrate_lens_command_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::filesystem::path kShared = PLEINAIR_SHARED_DIR;

class CalibrateLens : public CommandFolder {
 protected:
  // The focal length is 700 px.
  std::vector<std::filesystem::path> DrawnFiles() {
    std::vector<std::filesystem::path> files;
    for (const Rgb8Image& picture : DrawnBoards(640)) {
      files.push_back(folder_ / ("board" + std::to_string(files.size()) + ".png"));
      WritePng(files.back(), picture);
    }
    return files;
  }
};

// Fitted without a word about the kind of lens, and put into the site: its other keys stay.
TEST_F(CalibrateLens, WritesAPinholeIntoTheSite) {
  CalibrateLensOptions lens;
  lens.pictures = DrawnFiles();
  lens.board = "8x6";
  lens.site = folder_;
  lens.out = folder_ / "lens.json";
  Write("site.json",
        R"({"format": "pleinair-site", "version": 1, "note": "kept", "note_lens": "from EXIF data",
            "camera": {"camera_from_world":
              [[1, 0, 0, 0], [0, 0, -1, 1.5], [0, 1, 0, 0], [0, 0, 0, 1]]}})");
  const std::string report = RunCalibrateLens(lens);
  EXPECT_THAT(report, HasSubstr("pinhole: fx"));
  EXPECT_THAT(report, HasSubstr("board3.png: rms 0."));
  const StatedCamera camera = ReadStatedCamera(folder_);
  EXPECT_NEAR(camera.intrinsics.fx_px, 700.0, 7.0);
  EXPECT_NEAR(camera.intrinsics.fy_px, 700.0, 7.0);
  EXPECT_TRUE(camera.camera_from_world);
  EXPECT_EQ(ReadCameraIntrinsics(lens.out), camera.intrinsics);
  std::ifstream stream(folder_ / "site.json");
  const nlohmann::json written = nlohmann::json::parse(stream);
  EXPECT_EQ(written["note"], "kept");
  EXPECT_FALSE(written.contains("note_lens"));

  // Made for pictures of another size.
  Write("site.json", R"({"format": "pleinair-site", "version": 1,
                         "camera": {"width": 1280, "height": 960}})");
  EXPECT_THAT(Refusal(RunCalibrateLens, lens),
              HasSubstr("site.json: camera: expected 640x480, the size of the board's pictures"));
  lens.site.clear();
  lens.out.clear();
  EXPECT_THAT(Refusal(RunCalibrateLens, lens), HasSubstr("expected --out or --site"));
}

TEST_F(CalibrateLens, WritesAFisheyeIntoTheSite) {
  const std::filesystem::path boards = kShared / "data/lens_calibration/fisheye_board";
  if (!std::filesystem::is_directory(boards)) GTEST_SKIP() << "no pictures in " << boards;
  CalibrateLensOptions lens;
  for (const char* name : {"2", "3", "6", "8", "13", "14"}) {
    lens.pictures.push_back(boards / (std::string("Fisheye1_") + name + ".jpg"));
  }
  lens.board = "8x6";
  lens.site = folder_;
  Write("site.json", R"({"format": "pleinair-site", "version": 1,
                         "fisheye": {"model": "equidistant", "fov_deg": 180, "up": "+Z up",
                                     "width": 1032, "height": 778}})");
  EXPECT_THAT(RunCalibrateLens(lens), HasSubstr("fisheye: fx"));
  std::ifstream stream(folder_ / "site.json");
  const nlohmann::json fisheye = nlohmann::json::parse(stream)["fisheye"];
  EXPECT_EQ(fisheye["model"], "opencv");
  EXPECT_EQ(fisheye["up"], "+Z up");
  EXPECT_EQ(fisheye["calibration"], "fisheye.json");
  EXPECT_NEAR(ReadFisheyeCalibration(folder_ / "fisheye.json").intrinsics.fx_px, 337.0, 3.0);
}

TEST_F(CalibrateLens, CalibratesALensAndNamesWhatIsNoUse) {
  const std::filesystem::path boards = kShared / "data/lens_calibration/fisheye_board";
  if (!std::filesystem::is_directory(boards)) GTEST_SKIP() << "no pictures in " << boards;
  CalibrateLensOptions fisheye;
  for (const char* name : {"2", "3", "6", "8", "13", "14"}) {
    fisheye.pictures.push_back(boards / (std::string("Fisheye1_") + name + ".jpg"));
  }
  fisheye.pictures.push_back(folder_ / "absent.jpg");
  fisheye.pictures.push_back(folder_ / "grey.png");
  WritePng(folder_ / "grey.png", Rgb8Image(1032, 778, glm::u8vec3(90)));
  fisheye.pictures.push_back(folder_ / "small.png");
  WritePng(folder_ / "small.png", Rgb8Image(10, 10, glm::u8vec3(90)));
  fisheye.model = LensModel::kFisheye;
  fisheye.board = "8x6";
  fisheye.fov_deg = 186.0;
  fisheye.out = folder_ / "lens.json";
  const std::string report = RunCalibrateLens(fisheye);
  for (const char* name : {"absent.jpg", "grey.png", "small.png"}) {
    EXPECT_THAT(report, HasSubstr(std::string(name) + ": left out"));
  }
  const FisheyeCalibration lens = ReadFisheyeCalibration(fisheye.out);
  EXPECT_NEAR(lens.intrinsics.fx_px, 337.0, 3.0);
  EXPECT_NEAR(lens.intrinsics.max_angle_rad, RadFromDeg(93.0), 1e-12);
  EXPECT_LT(lens.rms_px.value(), 0.5);

  fisheye.out = folder_ / "other.json";
  fisheye.board = "8 by 6";
  EXPECT_THAT(Refusal(RunCalibrateLens, fisheye), HasSubstr("--board"));
  fisheye.board = "9x6";
  fisheye.pictures.resize(1);
  EXPECT_THAT(Refusal(RunCalibrateLens, fisheye), HasSubstr("found none"));
  EXPECT_FALSE(std::filesystem::exists(fisheye.out));
}

// With a wrong size OpenCV finds parts of the board, or nothing: no lens is written, and the size
// is named that fits.
TEST_F(CalibrateLens, NamesTheSizeOfBoardThatFits) {
  const std::filesystem::path boards = kShared / "data/lens_calibration/fisheye_board";
  if (!std::filesystem::is_directory(boards)) GTEST_SKIP() << "no pictures in " << boards;
  CalibrateLensOptions fisheye;
  // In the fourth the finder sees 6x6 of them alone, which would fit, too.
  for (const char* name : {"1", "2", "3", "4"}) {
    fisheye.pictures.push_back(boards / (std::string("Fisheye1_") + name + ".jpg"));
  }
  fisheye.out = folder_ / "lens.json";
  for (const char* wrong : {"5x4", "9x6"}) {
    fisheye.board = wrong;
    EXPECT_THAT(
        Refusal(RunCalibrateLens, fisheye),
        HasSubstr(std::string("--board ") + wrong + " does not fit, --board 8x6 does (rms 0."));
    EXPECT_FALSE(std::filesystem::exists(fisheye.out));
  }
}

TEST_F(CalibrateLens, UsesAPictureWhateverItsBlurWhereAsked) {
  CalibrateLensOptions lens;
  lens.pictures = DrawnFiles();
  const std::filesystem::path blurred = folder_ / "blurred.png";
  WritePng(blurred, Blurred(DrawnBoards(640)[2], 4.0));
  lens.pictures.push_back(blurred);
  lens.board = "8x6";
  lens.out = folder_ / "lens.json";
  EXPECT_THAT(RunCalibrateLens(lens), HasSubstr("blurred.png: left out: blurred"));
  lens.always_used = {blurred};
  EXPECT_THAT(RunCalibrateLens(lens), HasSubstr("blurred.png: rms "));
  lens.always_used = {folder_ / "board9.png"};
  EXPECT_THAT(Refusal(RunCalibrateLens, lens), HasSubstr("expected one of the pictures"));
  const std::filesystem::path grey = folder_ / "grey.png";
  WritePng(grey, Rgb8Image(640, 480, glm::u8vec3(90)));
  lens.pictures.push_back(grey);
  lens.always_used = {grey};
  EXPECT_THAT(Refusal(RunCalibrateLens, lens), HasSubstr("grey.png: cannot be used: no board"));
}

// Copies, and the pictures of a burst, count once: they agree with each other, and with any lens.
TEST_F(CalibrateLens, CountsPicturesOfOneViewOnce) {
  CalibrateLensOptions lens;
  lens.pictures = DrawnFiles();
  lens.board = "8x6";
  lens.out = folder_ / "lens.json";
  const Rgb8Image first = ReadDisplayImage(lens.pictures[0]);
  std::vector<std::filesystem::path> burst{lens.pictures[0]};
  for (int shift_px = 0; shift_px < 4; ++shift_px) {
    Rgb8Image moved = first;
    std::rotate(moved.pixels.begin(), moved.pixels.begin() + shift_px, moved.pixels.end());
    burst.push_back(folder_ / ("burst" + std::to_string(shift_px) + ".png"));
    WritePng(burst.back(), moved);
  }
  lens.pictures.insert(lens.pictures.end(), burst.begin() + 1, burst.end());
  const std::string report = RunCalibrateLens(lens);
  EXPECT_THAT(report, HasSubstr("burst3.png: left out: shows the board where "));
  EXPECT_THAT(report, HasSubstr("and do not count: 4\n"));
  EXPECT_THAT(report, HasSubstr("board0.png: rms 0."));
  EXPECT_NEAR(ReadCameraIntrinsics(lens.out).fx_px, 700.0, 7.0);

  lens.pictures = burst;
  lens.out = folder_ / "other.json";
  lens.force = true;
  EXPECT_THAT(Refusal(RunCalibrateLens, lens),
              AllOf(HasSubstr("--board 8x6 cannot be judged"),
                    HasSubstr("expected 3 different views of the board or more, found 1")));
  EXPECT_FALSE(std::filesystem::exists(lens.out));
}

// Squeezed pictures have pixels that are not square.
TEST_F(CalibrateLens, WritesALensInDoubtOnlyWhereForced) {
  const std::filesystem::path boards = kShared / "data/lens_calibration/fisheye_board";
  if (!std::filesystem::is_directory(boards)) GTEST_SKIP() << "no pictures in " << boards;
  CalibrateLensOptions fisheye;
  for (const char* name : {"2", "6", "13", "14"}) {
    const cv::Mat picture =
        cv::imread((boards / (std::string("Fisheye1_") + name + ".jpg")).string());
    cv::Mat squeezed;
    cv::resize(picture, squeezed, {}, 1.0, 0.9, cv::INTER_AREA);
    fisheye.pictures.push_back(folder_ / (std::string(name) + ".png"));
    cv::imwrite(fisheye.pictures.back().string(), squeezed);
  }
  fisheye.board = "8x6";
  fisheye.out = folder_ / "lens.json";
  EXPECT_THAT(Refusal(RunCalibrateLens, fisheye),
              AllOf(HasSubstr("corners are missed by 0."),
                    HasSubstr("fx within 3 % of fy"),
                    HasSubstr("nor does another size"),
                    HasSubstr("--force writes it")));
  EXPECT_FALSE(std::filesystem::exists(fisheye.out));
  fisheye.force = true;
  EXPECT_THAT(RunCalibrateLens(fisheye), HasSubstr("forced: corners are missed by 0."));
  const FisheyeIntrinsics lens = ReadFisheyeCalibration(fisheye.out).intrinsics;
  EXPECT_NEAR(lens.fx_px / lens.fy_px, 1.0 / 0.9, 0.02);
}

}  // namespace
}  // namespace pleinair::calibrate_lens_command_test
