# Plays JSON that `tactogram convert` wrote, on a game pad. Godot 4; add it to any scene as a node.
#
#     tactogram convert denim.wav denim.json --format gamepad
extends Node

const FORMAT := "gamepad-effects"

@export_file("*.json") var file := "res://denim.json"
@export var pad := 0


func play() -> void:
	var document = JSON.parse_string(FileAccess.get_file_as_string(file))
	if not document is Dictionary or document.get("format") != FORMAT:
		push_error("%s: expected a file of --format gamepad" % file)
		return
	for effect in document["effects"]:
		if effect["startDelay"] > 0:
			Input.stop_joy_vibration(pad)
			await get_tree().create_timer(effect["startDelay"] / 1000.0).timeout
		var seconds: float = effect["duration"] / 1000.0
		Input.start_joy_vibration(pad, effect["weakMagnitude"], effect["strongMagnitude"], seconds)
		await get_tree().create_timer(seconds).timeout
	Input.stop_joy_vibration(pad)
