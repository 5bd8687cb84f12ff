# ROS 2 looks for programs in lib/@(name), not in bin.
[develop]
script_dir=$base/lib/@(name)
[install]
install_scripts=$base/lib/@(name)
