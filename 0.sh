rosrun cloud_colorizer colorize_bag DRIVE.bag --output map.ply
rosrun cloud_colorizer render_map map.ply --output map.png
