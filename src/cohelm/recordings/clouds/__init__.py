"""Point clouds of KITTI, nuScenes and PCL as sensor recordings."""
