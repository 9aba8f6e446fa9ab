rosrun cloud_colorizer colorize_map --cloud cloud.ply --images images --model sparse --output colored.ply
