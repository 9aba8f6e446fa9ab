rosrun cloud_colorizer colorize_bag DRIVE.bag --config rig.yaml --recording recording --output map.ply voxel_size=0.1
rosrun cloud_colorizer colorize recording --output closest.ply method=closest
rosrun cloud_colorizer colorize recording --output filled.pcd uncolored=fill fill_distance=0.5
