// Exercise 5.4 in C++.
#include <algorithm>
#include <cmath>
#include <vector>

#include <cv_bridge/cv_bridge.h>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <ros/ros.h>
#include <sensor_msgs/Image.h>

namespace {

ros::Publisher publisher;

void find_tags(const cv::Mat& image, std::vector<std::vector<cv::Point2f>>& corners, std::vector<int>& ids) {
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
  cv::aruco::ArucoDetector(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_6X6_250))
      .detectMarkers(image, corners, ids);
#else
  cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_6X6_250), corners, ids);
#endif
}

void on_image(const sensor_msgs::ImageConstPtr& message) {
  cv_bridge::CvImagePtr image = cv_bridge::toCvCopy(message, "bgr8");
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  find_tags(image->image, corners, ids);
  if (ids.size() == 4) {
    cv::Point2f middle(0, 0);
    std::vector<cv::Point2f> centers;
    for (const auto& quad : corners) {
      centers.push_back((quad[0] + quad[1] + quad[2] + quad[3]) / 4);
      middle += centers.back() / 4;
    }
    std::sort(centers.begin(), centers.end(), [&](const cv::Point2f& one, const cv::Point2f& other) {
      return std::atan2(one.y - middle.y, one.x - middle.x) < std::atan2(other.y - middle.y, other.x - middle.x);
    });
    std::vector<std::vector<cv::Point>> polygon(1, std::vector<cv::Point>(centers.begin(), centers.end()));
    cv::fillPoly(image->image, polygon, cv::Scalar(0, 160, 0));
  }
  publisher.publish(image->toImageMsg());
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "polygon_cpp");
  ros::NodeHandle node;
  publisher = node.advertise<sensor_msgs::Image>("/cpp/image", 1);
  ros::Subscriber subscriber = node.subscribe("/camera/rgb/image_raw", 1, on_image);
  ros::spin();
  return 0;
}
