# Vibrates a game pad as strongly as the texture under the pointer, from the JSON of `tactogram touch`. Godot 4; add it
# to any scene as a node.
#
#     tactogram touch runs/corduroy --material corduroy --out corduroy.json
extends Node

const FORMAT := "tactogram-texture"
const VERSION := 1
const MILLIMETRES_PER_INCH := 25.4
const SMOOTHING_S := 0.03
const LONGEST_S := 0.1

@export_file("*.json") var file := "res://corduroy.json"
@export var pad := 0
## N; screens do not measure it.
@export var force_while_touching := 0.5

var texture: Dictionary
## Amplitudes in the felt band, in the texture's unit, and the largest of them.
var amplitudes: Array
var strongest := 1.0
var place := Vector2.ZERO  # mm
var path := 0.0  # mm
var speed := 0.0  # mm/s
var touching := false
var _path_before := 0.0


func _ready() -> void:
	var document = JSON.parse_string(FileAccess.get_file_as_string(file))
	if not document is Dictionary or document.get("format") != FORMAT or document["version"] != VERSION:
		push_error("%s: expected a file of tactogram touch, version %d" % [file, VERSION])
		set_process(false)
		set_process_input(false)
		return
	texture = document
	amplitudes = texture["arrays"]["vibration"]["values"]
	strongest = amplitudes.max()


func _input(event: InputEvent) -> void:
	if event is InputEventScreenTouch:
		touching = event.pressed
	elif event is InputEventMouseButton and event.button_index == MOUSE_BUTTON_LEFT:
		touching = event.pressed
	elif event is InputEventScreenDrag or event is InputEventMouseMotion:
		var millimetres := MILLIMETRES_PER_INCH / DisplayServer.screen_get_dpi()
		path += event.relative.length() * millimetres
		place = event.position * millimetres


func _process(delta: float) -> void:
	var moved := (path - _path_before) / delta
	_path_before = path
	speed += (1.0 - exp(-delta / SMOOTHING_S)) * (moved - speed)
	if not touching or speed < 1.0:
		Input.stop_joy_vibration(pad)
		return
	var share := amplitude_at(speed, force_while_touching) / strongest
	# The file does not tell how the strength is divided between low (strong) and high frequencies (weak).
	Input.start_joy_vibration(pad, share, share, LONGEST_S)


## Amplitude of the sine with the texture's power, in its unit.
func amplitude_at(v: float, force: float) -> float:
	if texture["kind"] == "surface":
		var along: float = {"x": place.x, "y": place.y, "path": path}[texture["along"]]
		return amplitudes[int(floor(along / texture["vibration_step_mm"])) % amplitudes.size()]
	var forces: Array = texture["arrays"]["forces"]["values"]
	var i := _node(v, texture["arrays"]["speeds"]["values"])
	var j := _node(force, forces)
	var slower := lerpf(_amplitude(i[0], j[0], forces), _amplitude(i[0], j[1], forces), j[2])
	var faster := lerpf(_amplitude(i[1], j[0], forces), _amplitude(i[1], j[1], forces), j[2])
	return lerpf(slower, faster, i[2])


func _amplitude(i: int, j: int, forces: Array) -> float:
	return amplitudes[i * forces.size() + j]


## The nodes on both sides of a value, and its share of the way between them.
func _node(value: float, nodes: Array) -> Array:
	var upper := nodes.bsearch(value)
	if upper == 0:
		return [0, 0, 0.0]
	if upper == nodes.size():
		return [upper - 1, upper - 1, 0.0]
	var low: float = nodes[upper - 1]
	return [upper - 1, upper, (value - low) / (nodes[upper] - low)]
