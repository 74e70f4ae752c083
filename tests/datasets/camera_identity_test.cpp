// What a camera is found by, from sysfs as the kernel lays it out.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "datasets/camera/internal/v4l2_device.h"

namespace pleinair::camera_identity_test {
namespace {

namespace fs = std::filesystem;

class CameraIdentity : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    std::strcpy(reinterpret_cast<char*>(camera_.card), "Made-up camera");
    std::strcpy(reinterpret_cast<char*>(camera_.bus_info), "usb-1.2");
  }
  void TearDown() override { fs::remove_all(root_); }

  // Two nodes of the device at `port`.
  void PlugIn(const std::string& port, int first_number, const std::string& serial) {
    const fs::path device = root_ / "devices" / port;
    fs::create_directories(device / "interface");
    Write(device / "idVendor", "046d\n");
    Write(device / "idProduct", "0825\n");
    if (!serial.empty()) Write(device / "serial", serial + "\n");
    for (int index = 0; index < 2; ++index) {
      const fs::path node = sysfs_ / ("video" + std::to_string(first_number + index));
      fs::create_directories(node);
      Write(node / "index", std::to_string(index) + "\n");
      fs::create_directory_symlink(device / "interface", node / "device");
    }
  }
  std::string Of(int number) const { return IdentityOf(number, camera_, sysfs_); }

  static void Write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

  fs::path root_ = fs::path(testing::TempDir()) / "pleinair_camera_identity";
  fs::path sysfs_ = root_ / "class";
  v4l2_capability camera_{};
};

TEST_F(CameraIdentity, IsTheSerialNumberAtAnyPort) {
  PlugIn("1-1", 0, "A1B2");
  PlugIn("1-2", 2, "C3D4");
  EXPECT_EQ(Of(0), "046d:0825:A1B2:0");
  EXPECT_EQ(Of(1), "046d:0825:A1B2:1");
  EXPECT_EQ(Of(2), "046d:0825:C3D4:0");
  fs::remove_all(sysfs_);
  PlugIn("2-7", 5, "A1B2");
  EXPECT_EQ(Of(5), "046d:0825:A1B2:0");
}

TEST_F(CameraIdentity, IsThePortAndTheNodeWithoutASerialNumber) {
  PlugIn("1-1", 0, "");
  EXPECT_EQ(Of(0), "Made-up camera|usb-1.2|0");
  EXPECT_EQ(Of(1), "Made-up camera|usb-1.2|1");
}

// As a stand-in's camera: nothing of it is in sysfs.
TEST_F(CameraIdentity, DoesNotNeedSysfs) { EXPECT_EQ(Of(0), "Made-up camera|usb-1.2|0"); }

}  // namespace
}  // namespace pleinair::camera_identity_test
