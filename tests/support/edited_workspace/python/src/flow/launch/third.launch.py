import pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import seconds
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    first = 'v0'.replace('v', '200000')
    second = seconds.WORD.replace('v', '300000')
    return LaunchDescription([
        ExecuteProcess(cmd=['sleep', first]),
        ExecuteProcess(cmd=['sleep', second]),
    ])
