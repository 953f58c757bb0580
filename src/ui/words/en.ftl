# Plenoscope in English. How a text is added, and how a language: CONTRIBUTING.md.
# { $name } is put in; numbers come with the decimals that they are to have.

language-name = English
# `leftward` where it is read from right to left.
reading = rightward
number-decimal = .
number-group = ,

## Units behind numbers.
suffix-px = {" "}px
suffix-px-view = {" "}px/view
suffix-m = {" "}m
suffix-s = {" "}s
language-unreadable = a language cannot be read — it is no text file, opens too many braces in one text, or its name is no language’s — name it as de.ftl or pt-BR.ftl: { $path }
language-damaged = { $count ->
    [one] One text of a language cannot be read, in line { $line }: { $path }
   *[other] { $count } texts of a language cannot be read, the first in line { $line }: { $path }
}
depths-view = view ({ $v }, { $u })
depths-readout = x { $x }, y { $y } · { $view } · { $disparity } px/view
points-none = The points come with the light field
points-canvas = Points canvas
points-readout = { $count } points · turned { $yaw }°, { $pitch }° · { $zoom } ×
points-filling = { " " }· adding what other views see

## Nothing is open.
empty-title = Drop a photo to look into it
empty-promise = One photo becomes a light field: look round, focus anywhere, open the lens
open = Open…
paste = Paste
try-sample = Try the sample
recent = Recent
drop-instead = Drop to open instead
drop = Drop to open

## The top bar.
face = Face
face-picture = Picture
face-views = Views
face-depths = Ray depths
face-points = Points
export-open = Export…
before-after = Before / after
inspector = Inspector

## The status line.
others-more = · { $count } more
queue-name = Queue
drawn-by = drawn by { $device }
drawn-by-threads = drawn by { $device } · nets on { $threads ->
    [one] 1 CPU thread
   *[other] { $threads } CPU threads
 }
zoom = zoom { $percent } %
idle-nothing = Everything stays on this computer
idle-photo = Drag to look round · click to focus · wheel to zoom · F1 for all keys
idle-field = Drag to look round · wheel to zoom · F1 for all keys
idle-flat = No light field · wheel to zoom
esc-stops = { $time } · Esc stops

## Which source of depth is looked at.
source-made = { $name } is being made · { $number } of { $count } · S next · Esc back
source-compared = { $name } · { $number } of { $count } · S next · Shift+S keeps it · Esc back
source-alone = { $name } · S compares { $count } sources
the-processor = the processor
no-device = no device

## The export dialog.
export-photos = Export { $count ->
    [one] 1 photo
   *[other] { $count } photos
 }
export = Export
cancel = Cancel
eyes-apart = Eyes apart
suffix-views = { " " }views
more-is-deeper = more is deeper
display = Display
quilt-holds = { $count } viewpoints in { $cols } × { $rows } tiles, { $width } × { $height } px
holds = Holds
views-of = { $cols } × { $rows } views of { $width } × { $height } px
size = Size
size-of-views = { $width } × { $height } px, that of the views
frames = Frames
suffix-a-second = { " " }a second
seconds = { $secs } s
moves = Moves
fits-into = Fits into
format = Format
long-side = Long side
photo = Photo
pixels = { $width } × { $height } px
quality = Quality
bit-depth = Depth
bits-8 = 8 bits
bits-16 = 16 bits
metadata = Metadata
keep-all = Keep all
without-place = Without the place
drop-all = Drop all
inside = Inside
inside-nothing = Nothing goes along where all metadata is dropped
inside-edit = Edit
inside-edit-hint = The picture knows how it was made: opened again, photo and edit are back
inside-depth = Depth
inside-depth-hint = The depth map, as phones write it (GDepth)
inside-photo-hint = The photo's file itself, so that the edit needs nothing beside it
name = Name
name-hint = {"{name}"}, {"{f}"} and {"{focus}"} are filled in
folder = Folder
choose = Choose…
beside-photo = Beside photo
beside-photo-hint = Write beside each photo
if-it-exists = If it exists
exists-number = Add a number
exists-replace = Replace
exists-leave = Leave it
writes = Writes

## The settings.
settings = Settings
language = Language
language-system = As the system ({ $name })
theme = Theme
theme-dark = Dark
theme-light = Light
theme-system = System
light-field = Light field
long-side-px = { $side } px
occlusions = Occlusions
occlusions-correct = Correct them by the second net
edits = Edits
edits-hint = A small file beside each photo: photo.jpg.plenoscope.json
edits-keep = Keep them beside their photos
models = Models
built-in = Built-in
models-own = those in the program
done = Done

## Where ray depths come from.
source-network = Network
section-source = Source of ray depths
link-depth-map = depth map…
link-compare = compare
source = Source
model = Model
model-built-in = built-in
add-net-hint = An ONNX file: it is tried on the sample and kept. A file can be dropped on the window, too
add-net = Add a depth net…
use-for-all = Use for all photos
remove-net = Remove { $name }
section-light-field = Light field
views-count = { $cols } × { $rows } views
made-by = Made by
from-disk = from disk
took = Took
views-lie = Views lie

## Depth mended by hand.
section-repair = Repair
link-done = done
link-mend = mend
repair-tool = Repair tool
repair-brush = Repair brush
brush = Brush
brush-hint = Its diameter, of the longer side. Wheel
brush-strength = Strength
brush-strength-hint = How much a stroke does
reach-hint = How far the thing reaches from the click, of the longer side. Wheel
reach = Reach
by = By
by-hint = By how much Nearer and Farther move the thing
nearer = Nearer
nearer-hint = All of the thing comes nearer
farther = Farther
farther-hint = All of the thing goes farther away
flatten = Flatten
flatten-hint = A card that faces the camera
stand = Stand
stand-hint = A vertical plane on the thing's foot
lie = Lie
lie-hint = A part of the ground around the thing
join = Join
join-hint = The depth of the neighbour that goes on in the same colours
draw-round = Draw round a thing in the picture
click-thing = Click a thing in the picture; the wheel grows it
repair-unknown = Not known to this version
repair-remove-hint = Take this repair away
repair-remove = Remove repair { $number }

## The shape of the opening.
opening-own-hint = A picture of your own: white is open
opening-own = picture…
disc = disc
disc-hint = A round lens
square = square
square-hint = The square of the light field's own views
blades = blades
blades-hint = A polygon of straight blades
ring = ring
ring-hint = A mirror lens
cats-eye = cat's eye
cats-eye-hint = A disc cut by the barrel towards the corners
opening-picture = picture
opening-picture-hint = A picture of your own
blade-count = Blades
blade-count-hint = Straight edges
rotation = Rotation
rotation-hint = Turns the blades
roundness = Roundness
roundness-hint = 0 straight, 1 a disc
hole = Hole
hole-hint = Radius of the mirror's hole
cats-eye-strength = Cat's eye
cats-eye-strength-hint = How much the barrel cuts in the corners
opening-preview = The opening: light behind the focus takes this shape

## What else a lens does.
anamorphic = Anamorphic
anamorphic-hint = Discs taller than wide: 1 is twice as tall
spherical = Spherical
spherical-hint = Discs behind the focus: 1 a bright rim, −1 a bright middle
fringes = Fringes
fringes-hint = Rims green behind the focus, magenta before it
swirl = Swirl
swirl-hint = Discs cut towards the corners, and a curved sharp surface
section-glass = Glass

## A box for a path.
path-open = Open
path-open-what = a photo or light field
path-export = Export photos
path-export-what = a photo
path-depth = Depth map
path-depth-what = a PFM or grey picture
path-opening = Opening of the lens
path-opening-what = a picture; white is open
path-models = Models
path-models-what = a folder of models
path-net = Depth net
path-net-what = an ONNX file
path-fields = Light fields to train on
path-fields-what = a folder of light fields
verb-open = Open
verb-go-on = Go on
verb-use = Use
verb-add = Add
path-ask = The system shows no file dialog here. Type or paste the path of { $what }
path-none = could not open — that is no path of a file — begin it with / or ~

## Presets.
presets = Presets
presets-none = None yet: lens and export are kept under the name you give
presets-some = Lens and export; the focus stays
preset-name = Name of a new one
keep = Keep
close = Close
remove = Remove
apply = Apply

## The queue.
clear-ended = Clear ended
add-photos = Add photos…
queue-empty = Nothing is being exported
show-in-folder = Show in folder
stop = Stop
waits = waits
task-done = done
was-there = was there already
stopped = stopped

## The lens in a photographer's numbers.
section-real-lens = Real lens
distance-tip = With one distance the lens reads in metres; what is farthest is taken for very far away
distance-give = give the distance of what is in focus
distance = Distance
distance-hint = How far away what is in focus is
distance-forget = forget the distance
length-give = or the length of something in it
length-tip = Draw a line over something whose length you know: how far away it is follows
length-draw = drag from one end to the other in the picture
length = Length
length-hint = How long it is; its distance follows from the focal length
length-done = take the line away
open-as = open as … ▼
lens-blades = { " " }· { $count } blades
lens-nearest = { " " }· from { $metres } m
lens-cut = The aperture of { $lens } is beyond what there is here: { $reading }

## How deep the scene is.
strength-hint = How deep the scene is: the distance of the views, against how it was made
strength-hint-field = How far the views stand apart; those of a recorded light field no farther than they were
strength = Strength
strength-slider = Strength slider
baseline-reach = Rays reach over { $percent } % of the baseline
baseline-reach-hint = How far the outermost views stand from the first photo, against how far the camera did; the strength sets it

## The views.
views = Views
views-all = all { $count } ▶
all-views = All views
view-at = View { $v }, { $u }
view-step = u { $u }, v { $v }

## Which end of a map is near.
near-end-title = Which one has near things in yellow?
near-end-ask = { $name } does not say which end of its values is near. Click the picture that is right
near-large = Large values are near
near-small = Small values are near
near-likely = { $name } · likely

## How bright the picture is.
section-histogram = Histogram
clipped = { $dark } clipped dark · { $bright } clipped bright
histogram-said = Histogram, { $text }
percent = { $share } %
percent-below = < { $share } %

## Told once.
got-it = Got it
hint-look = Drag the picture to look round
hint-focus = Click what should be sharp
hint-export = Export saves the picture as you see it

## Several files at once.
files-count = { $count ->
    [one] 1 file
   *[other] { $count } files
 }
and-more = and { $count } more
many-ask = Photos of one subject, taken from places a little apart – or each for itself?
one-subject-hint = A hand took them from places a little apart: depth is measured, and what one hides another shows
one-subject = One subject
take-mean = Less noise: the mean of the photos
take-mean-hint = Where the others show the same, the first photo takes the mean of all of them; off, it stays as it is
open-first = Open the first
export-all-hint = Each one becomes a light field and is written with the lens that is set now
export-all = Export all…

## The shortcut sheet.
shortcuts = Shortcuts
mouse = Mouse

## The depth ruler.
ruler-far = far
ruler-near = near
depths-coming = ray depths are on their way
depths-none = no ray depths
ruler-hint = depth ruler: drag to focus, drag the band's edges to keep more sharp
focus = Focus
sharp-far-edge = Keep sharp, far edge
sharp-near-edge = Keep sharp, near edge
zero-px-view = 0 px/view

## Epipolar images.
epi-row = EPI u · row { $row }
epi-column = EPI v
slope = slope
px-view = px/view
the-row = the row
the-column = the column
repair-canvas = Repair canvas
slope-of = Slope of { $line }

## The ray depths' face.
no-depths-yet = No ray depths yet
depths-canvas = Ray depths canvas

## The picture.
picture-canvas = Picture canvas
split-photo = Photo
split-refocused = Refocused
kept-sharp = Kept sharp { $number }
readout-place = x { $x }, y { $y }
readout-view = { " " }· view ({ $u }, { $v })
readout-depth = { " " }· { $disparity } px/view

## The inspector.
section-lens = Lens
peaking = Focus peaking
trust = Trust view
invented-most = Invented at most
invented-most-hint = How much of the picture may be invented: the marks on aperture and pad
aperture = Aperture
aperture-hint = How wide the lens opens
aperture-slider = Aperture slider
aperture-beyond = Beyond f/{ $f } more than { $percent } % of the picture is invented
synthetic-hint = Synthetic: wider than the light field
synthetic = synthetic: wider than the light field
focus-number = Focus
focus-hint = Disparity that is sharp
keep-sharp = Keep sharp
keep-sharp-hint = Depths around the focus that stay sharp too · double-click resets
sharp-nearer = Keep sharp, nearer
sharp-nearer-hint = Towards the eye
sharp-farther = Keep sharp, farther
sharp-farther-hint = Away from the eye
tilt-across = Tilt across
tilt-across-hint = Focal plane: growth from the left edge to the right
tilt-down = Tilt down
tilt-down-hint = Focal plane: growth from the upper edge to the lower
highlights = Highlights
highlights-hint = Brightens clipped lights before they are blurred (at photo size)
grain = Grain
grain-hint = Puts the photo's own grain back into what is blurred (at photo size)
section-viewpoint = Viewpoint
link-centre = centre ↺
link-stop-circle = stop circle
link-circle = ▶ circle
drag-to-look =
    drag the picture
    to look round
step-hint = Steps from where the photo was taken
pivot-hint = The disparity of what stays where it is while you look round; Ctrl-click sets it
pivot = Pivot
pad = Viewpoint pad
pad-hint = Click or drag: where the eye is. Brighter cells hold less that was invented, those within the line no more than is set. Shift: between views
section-depths = Ray depths
depths-picture = Ray depths picture
depths-far = far { $disparity }
depths-near = near { $disparity }

## The timeline.
preset-pull = Focus pull
    .hint = The focus, from far to near
preset-subjects = Subject to subject
    .hint = The focus, from what is sharp to the next, and back
preset-circle = Circle
    .hint = The eye, once round
preset-breathing = Breathing
    .hint = The lens closes and opens again
preset-dolly = Dolly
    .hint = The strength grows around a subject that stays sharp
film-stop = Stop
film-play = Play
set-key = Set key
add-key = Add key
remove-key = Remove key
hold-focus = Focus
hold-aperture = Aperture
hold-eye = Eye
hold-strength = Strength
key-holds = Holds
key-holds-hint = What a new key holds
film-presets = Presets
film-none = None
film-none-hint = Take all keys away
ease-smooth = Smooth
ease-even = Even
ease-in = Slow start
ease-out = Slow end
easing = Easing
run-once = Once
run-loop = Loop
run-ping-pong = Ping-pong
at-the-end = At the end
seconds-hint = How long the film is
film-seconds = Seconds
chosen-said = { $name }: { $value }
playhead = Playhead, seconds
timeline-empty = set lens and eye, then add a key; go on along the line, and add the next
key-said = Key { $number } at { $secs } s: { $what }

## A net that was added.
added-title = Added { $name }
the-sample = The sample
its-depth = Its depth by this net
use-for-all-hint = For every photo without depth of its own

## The program broke off.
broke-title = A fault in Plenoscope
go-on = Go on
copy-report = Copy report
hide-report = Hide report
show-report = Show report
broke-told = Something broke the last time. A report was kept on this machine: it holds no picture, and of files no more than names. Nothing was sent. It helps whoever mends the fault.

## What happened, in a corner.
saved = Saved { $name }
less = Less
details = Details
licence-unknown = not known: look where you got it
unknown = not known
fact-family = Family
fact-size = Size
megabytes = { $size } MB
fact-time = Time
seconds-a-photo = { $secs } s a photo
fact-licence = Licence
fact-order = Order of the sample's depth
correlation = correlation { $value }
no-folder-for-nets = the system names no folder for nets — set HOME — then add it again

## Names of sources of depth.
source-gaussians = Gaussians
source-photos = { $count } photos
source-map = Your map
source-phone = Phone
source-fused = Fused

## What screen readers are told.
said-layer = layer { $number } of { $count }, f/{ $f }
said-left = , { $steps } left
said-right = , { $steps } right
said-up = , { $steps } up
said-down = , { $steps } down
said-runs = { $stage }, { $percent } per cent
plane-leans = the focal plane leans through all rings
plane-none = no plane goes through the rings: a band of depths keeps them sharp

## What was opened.
was-made-of = { $picture } was made of { $photo }: here it is, with that edit
size-only = { $width } × { $height }
bits = { $bits } bits
phone-depth = phone depth found
progress-of = { $stage } · { $done } of { $total }
time-left = { $elapsed } · { $left } left
minutes = { $minutes } min
one-source = This photo has one source of depth: drop a depth net (.onnx) on the window to have another
presets-no-folder = presets cannot be kept — the system names no folder for settings — set HOME
paste-no-edit = nothing to paste — the clipboard holds no edit — copy one from another photo first (Copy edit)
paste-nothing = nothing to paste — the clipboard holds no picture and no path of a file — copy a picture or a path first
paste-no-answer = could not paste — the system's clipboard does not answer — open the file instead
keys-most = no key is added — the timeline has { $most } already — remove one first
device-lost = The graphics device was lost. Your picture and its edit are back.
edited-elsewhere = This photo was edited elsewhere meanwhile; that edit is kept as { $name }
edit-not-kept = the edit is not kept beside the photo — { $why } — copy the photo to a folder of yours, or turn this off in the settings
left-as-it-was = { $name } is there already and was left as it is
copied-picture = Copied the picture, { $width } × { $height } px
other-shape = this depth map is not this photo's — it has another shape — use one of the photo's shape
no-folder-dialog = The system shows no folder dialog here: type the folder into the field
preset-applied = Applied the preset to lens and export
edit-copied = Copied the edit: paste it over another photo
edit-no-photo = the edit cannot be applied — nothing is open — open a photo first
edit-applied = Applied the edit
nothing-to-export = nothing to export yet — the light field is still being made — wait for it to end
stereo-anaglyph = Both eyes in one picture, for red-cyan glasses
stereo-parallel = Both eyes beside each other, left eye left
stereo-crossed = Both eyes beside each other, left eye right: cross your eyes
stereo-off = One picture for both eyes
tool-thing = Thing
tool-lasso = Lasso
tool-nearer = Nearer
tool-farther = Farther
tool-smooth = Smooth
tool-edge = Edge
photo-last = This is the last photo of its folder
photo-first = This is the first photo of its folder
folder-unreadable = could not look into the folder — { $why } — check that you may read it: { $folder }
repair-refused = this cannot be mended — it lies beside the photo, or { $most } repairs are there already
job-broke = the job broke off — a fault in the program ({ $what }) — try again, and report it if it happens twice
resets = { $hint } · double-click resets
pasted-picture = Pasted picture

## Menu and tool tips: what can be done.
menu-file = File
menu-edit = Edit
menu-viewpoint = Viewpoint
menu-film = Film
menu-view = View
menu-light-field = Light field
menu-help = Help
command-open = Open…
    .hint = Open a photo or a light field
command-open-folder = Open folder…
    .hint = Open a folder of views
command-open-sample = Try the sample
    .hint = Open the built-in picture
command-paste = Paste
    .hint = Open the picture or path in the clipboard, or apply the edit in it
command-previous-photo = Previous photo
    .hint = Open the photo before this one
command-next-photo = Next photo
    .hint = Open the photo after this one
command-export = Export…
    .hint = Save the picture, or anything else it can become
command-export-photos = Export photos…
    .hint = Export other photos with this edit
command-queue = Queue
    .hint = What is being exported, and what waits
command-settings = Settings…
    .hint = Theme, language, light field, models
command-copy-picture = Copy picture
    .hint = Put the picture into the clipboard
command-stop = Stop
    .hint = Stop what is running
command-quit = Quit
    .hint = Close the window
command-undo = Undo
    .hint = Take the last edit back
command-redo = Redo
    .hint = Do the last edit again
command-copy-edit = Copy edit
    .hint = Put lens, focus and viewpoint into the clipboard
command-paste-edit = Paste edit
    .hint = Apply the edit in the clipboard
command-presets = Presets…
    .hint = Lens and export under a name
command-reset-lens = Reset lens
    .hint = Back to f/3.5, focus in the middle
command-reset-viewpoint = Centre viewpoint
    .hint = Back to where the photo was taken
command-step-left = Step left
    .hint = Move the eye one view left
command-step-right = Step right
    .hint = Move the eye one view right
command-step-up = Step up
    .hint = Move the eye one view up
command-step-down = Step down
    .hint = Move the eye one view down
command-circle = Circle
    .hint = Let the viewpoint go round
command-nearer = Nearer layer
    .hint = Focus on the next nearer depth layer
command-farther = Farther layer
    .hint = Focus on the next farther depth layer
command-film = Timeline
    .hint = Show or hide the keys of a film
command-play-film = Play
    .hint = Show the film, or end it
command-add-key = Add key
    .hint = Keep lens and eye as they are at the playhead
command-earlier = Earlier
    .hint = Move the playhead back
command-later = Later
    .hint = Move the playhead on
command-picture = Picture
    .hint = The refocused picture
command-views = Views
    .hint = All views of the light field
command-depths = Ray depths
    .hint = Ray depths of the current view
command-points = Points
    .hint = The scene as points: a drag turns it, a double click turns it back
command-toggle-depth = Ray depths on and off
    .hint = Change between picture and ray depths
command-before-after = Before / after
    .hint = The photo left of the line, the picture right
command-stereo = Both eyes
    .hint = Red-cyan, beside each other, crossed, and off
command-peaking = Focus peaking
    .hint = Mark the edges that are in focus
command-trust = Trust view
    .hint = Tint what was invented, not seen
command-fit = Fit
    .hint = Show the whole picture
command-one-to-one = 1:1
    .hint = One picture pixel for one screen pixel
command-zoom-in = Zoom in
    .hint = Closer
command-zoom-out = Zoom out
    .hint = Farther
command-toggle-inspector = Inspector
    .hint = Show or hide the panel on the right
command-full-screen = Full screen
    .hint = Use the whole screen
command-next-theme = Theme
    .hint = Dark, light, or as the system
command-clear-recent = Forget recent files
    .hint = Empty the list of recent files
command-own-depth = Depth map…
    .hint = Take ray depths from a map of your own
command-compare-sources = Compare sources
    .hint = Show the next source of ray depths; Esc goes back
command-keep-source = Keep this source
    .hint = Use the source that is compared
command-repair = Repair depth
    .hint = Mend what the depth got wrong, by hand
command-opposite = Exchange near and far
    .hint = Turn the sign of every disparity
command-transpose = Exchange rows and columns
    .hint = Rows of views are columns
command-serpentine = To and fro
    .hint = Every second row of views runs backwards
command-train = Train…
    .hint = Train nets on your own light fields
command-shortcuts = Shortcuts
    .hint = All keys and what the mouse does

## Training.
training = Train on your light fields
training-what = Choose a folder of light fields: the paper's nets are trained on them, and can be used for your photos
training-choose = Choose folder…
training-start = Train
training-pause = Pause
training-go-on = Go on
training-use = Use this net
training-sheet = What the nets make of light fields they have just seen: photo, true and own ray depths, epipolar images
training-said = Losses: { $text }
training-waits = { $name }: not begun
training-begins = { $name }: getting ready…
training-runs = { $name }: step { $step } of { $all }; the window can be used meanwhile
training-ends = { $name }: saving after step { $step }…
training-rests = { $name }: resting after step { $step } of { $all }
training-another = something else is being trained — pause it first

## Keys that have names.
key-ctrl = Ctrl
key-shift = Shift
key-left = Left
key-right = Right
key-up = Up
key-down = Down
key-escape = Escape
key-home = Home
key-page-up = PageUp
key-page-down = PageDown
key-comma = Comma
key-period = Period

## What the mouse does.
mouse-drag = Drag the picture
    .hint = Look round
mouse-click = Click the picture
    .hint = Focus there
mouse-shift-click = Shift-click
    .hint = Keep this sharp, too
mouse-ctrl-click = Ctrl-click
    .hint = Turn around this while looking round
mouse-wheel = Wheel
    .hint = Zoom at the pointer
mouse-pan = Middle drag, Space + drag
    .hint = Move the picture
mouse-epipolar = Drag in an epipolar image
    .hint = Set a thing's depth
mouse-hold = Hold \
    .hint = Show the photo itself
mouse-double-click = Double-click a value's name
    .hint = Reset it

## What the library says in English, as it says it: recognised, and said in the language of the window. A `number` is one.

# Stages of a job.
heard-stage-open = Opening
heard-stage-depth = Estimating ray depths
heard-stage-warp = Rendering views
heard-stage-occlusion = Correcting occlusions
heard-stage-sweep = Measuring ray depths
heard-stage-match = Matching the photos
heard-stage-poses = Finding the cameras
heard-stage-mean = Taking the photos' mean
heard-stage-mend = Mending the depth
heard-stage-refocus = Refocusing
heard-stage-save = Saving

# What can be exported.
heard-group-pictures = Pictures
heard-group-light-field = Light field
heard-group-depth = Depth
heard-picture = Picture
heard-picture-hint = The refocused picture at the photo's own size
heard-focal-stack = Focal stack
heard-focal-stack-hint = A folder of pictures focused from far to near, one all sharp, and which is sharp where
heard-animation = Animation
heard-animation-hint = A focus pull, an opening lens, or a turn of the viewpoint
heard-video = Video
heard-video-hint = A film in AV1, MP4 or WebM: a focus pull, or what the timeline says
heard-frames = PNG sequence
heard-frames-hint = A folder with each frame of that film as PNG, for programs that cut
heard-living = Living picture
heard-living-hint = One HTML file to focus and to look round in, in any browser, without a connection
heard-side-by-side = Side by side
heard-side-by-side-hint = Both eyes beside each other, for 3-D screens and glasses
heard-mpo = Stereo pair, MPO
heard-mpo-hint = Both eyes as two JPEGs in one file, for 3-D screens and cameras
heard-spatial = Spatial photo
heard-spatial-hint = Both eyes as a spatial photo, one HEIC, for headsets and phones
heard-anaglyph = Anaglyph
heard-anaglyph-hint = Both eyes in one picture, for red-cyan glasses
heard-views = Views and ray depths
heard-views-hint = A folder with each view as PNG and its ray depths as PFM; opens again as it is
heard-eslf-hint = One lenslet picture, 14 × 14 pixels a lens, as the Light Field Toolbox reads it
heard-hci = HCI folder
heard-hci-hint = As the 4-D light field benchmark's own scenes, with ray depths
heard-stanford = Stanford folder
heard-stanford-hint = Numbered views named as in the Stanford archive
heard-quilt = Looking Glass quilt
heard-quilt-hint = Many viewpoints in one picture, for a holographic display
heard-depth-png = Depth map, PNG
heard-depth-png-hint = 16-bit grey, white is near
heard-depth-pfm = Depth map, PFM
heard-depth-pfm-hint = Disparity in pixels per view, every bit kept
heard-gdepth = Photo with depth
heard-gdepth-hint = A JPEG with the depth inside (GDepth), as phones write it
heard-ply = Point cloud
heard-ply-hint = PLY: each pixel as a coloured point in space
heard-gaussians = Gaussian splats
heard-gaussians-hint = PLY: a scene that splat viewers open, one Gaussian for each point that is seen; opens again

# What moves in a film.
heard-moves-focus = Focus
heard-moves-focus-hint = The focus, from far to near
heard-moves-aperture = Aperture
heard-moves-aperture-hint = The aperture, from f/28 to what is set
heard-moves-viewpoint = Viewpoint
heard-moves-viewpoint-hint = The eye, once round
heard-moves-subjects = Subjects
heard-moves-subjects-hint = The focus, from what is sharp to the next, and back
heard-moves-breathing = Breathing
heard-moves-breathing-hint = The lens, which closes and opens again
heard-moves-dolly = Dolly
heard-moves-dolly-hint = The strength, around a subject that stays sharp
heard-moves-timeline = Timeline
heard-moves-timeline-hint = What the recipe's timeline says
heard-key-focus = focus
heard-key-aperture = aperture
heard-key-eye = eye
heard-key-strength = strength

# Colours of ray depths.
heard-gray = gray

# Repairs.
heard-repair-nearer = Nearer
heard-repair-farther = Farther
heard-repair-flatten = Flatten
heard-repair-stand = Stand upright
heard-repair-lie = Lie on the ground
heard-repair-join = Join with neighbour
heard-repair-to = Move to a depth
heard-repair-brush-nearer = Nearer brush
heard-repair-brush-farther = Farther brush
heard-repair-brush-smooth = Smooth
heard-repair-brush-edge = Sharpen edge
heard-repairs-one = one repair of this edit cannot be done — of a later version, beside the photo, of impossible numbers, or more than { $number } — the rest is done, and the file keeps them all
heard-repairs-some = { $count } repairs of this edit cannot be done — of a later version, beside the photo, of impossible numbers, or more than { $number } — the rest is done, and the file keeps them all
heard-repairs-other-photo = the repairs of this edit are of another photo, so they are left out — the rest of it is applied, and its file keeps them

# How the views of a light field lie.
heard-layout-as-is = as they are
heard-layout-serpentine = every second row backwards
heard-layout-transposed = rows and columns exchanged
heard-layout-flip-v = upside down
heard-layout-flip-u = left to right
heard-made-by-own-depth = the picture's own depth

# The lens in a photographer's numbers.
heard-full-frame = full frame
heard-one-inch = 1 inch
heard-lens-title = { $number } mm f/{ $f } on { $format }
heard-lens-assumed = f/{ $f } on { $format }, if taken with { $number } mm
heard-lens-relative-title = { $title } · relative, as no distance is known
heard-lens-relative = relative: no distance is known here
heard-lens-focus = focus at { $distance } · sharp { $range }
heard-lens-focus-far = focus very far away · sharp { $range }
heard-lens-hyperfocal = hyperfocal distance { $distance }
heard-lens-blur = blur of what is farthest { $um } µm · { $px } px
heard-lens-none = the photo names no lens: { $number } mm is assumed
heard-lens-range = { $near } … { $far }
heard-lens-from = from { $near } on
heard-lens-all-far = all that is far
heard-distance-mm = { $number } mm
heard-distance-cm = { $number } cm
heard-distance-m = { $number } m
heard-distance-km = { $number } km

# A depth net's licence.
heard-licence-large = the weights of Large, Giant and Nested are for non-commercial use alone
heard-licence-nobody = nobody says whose its weights are
heard-licence-base = the weights of Base and Large are for non-commercial use alone
heard-licence-not-for-sale = its weights are for non-commercial use alone
heard-licence-version = version 2 of these weights is for non-commercial use alone; version 1 is Apache-2.0

# A file does not open.
heard-stopped = stopped
heard-read = could not read the file — { $why } — check that it is there and that you may read it
heard-empty = could not open the file — it is empty — copy it again from where it came from
heard-unknown = could not open the file — it is no picture and no light field — open a JPEG, PNG, WebP, TIFF, BMP, GIF, HEIC or AVIF photo, or a light field
heard-damaged = could not open the { $format } file — { $why } — copy it again, or save it anew with the program that made it
heard-truncated = could not open the { $format } file — it is cut off — copy it again from where it came from
heard-unsupported = could not open the { $format } file — { $why } — { $advice }
heard-too-long = could not open the file — it has { $number } KiB, where { $most } KiB are the most — choose another one
heard-too-large = could not open the file — its header says { $width }×{ $height } pixels, more than fit into { $number } MiB — scale it down first
heard-implausible = could not open the file — its header says { $width }×{ $height } pixels, and it has only { $number } KiB — copy it again, or save it anew with the program that made it
heard-missing-view = could not open the light field — view (v { $v }, u { $u }) of { $rows }×{ $cols } is missing — put the file back into the folder
heard-odd-view = could not open the light field — one view has { $width }×{ $height } pixels, the others { $others } — make all views with one size
heard-bad-field = could not open the light field — { $why } — make all views again with one size
heard-bad-opening = this picture cannot be the opening of a lens — { $why } — take a small one in which white is open
heard-empty-folder = could not open the folder — it holds no picture and no light field — choose another one
heard-changed = the photo has changed since it was opened — its file has another size now — open it again
heard-reduced = the photo has { $number } megapixels — it is shown with { $width }×{ $height }, and a picture is exported as large as its file
heard-too-large-for-it = it is too large for what it should be
heard-is-folder = it is a folder
heard-no-ordinary-file = it is no ordinary file
heard-no-text = it is no UTF-8 text
heard-no-such-file = No such file or directory (os error 2)
heard-permission-denied = Permission denied (os error 13)
heard-field-grid = a light field has 1 to 17 rows and columns of views, not { $rows }×{ $cols }
heard-field-length = { $what } has { $number } values where its size needs { $most }
heard-field-not-a-number = { $what } cannot be used — it has values that are not numbers (NaN or infinity) — repair it first
heard-field-view-size = view ({ $v }, { $u }) is { $got } pixels where the others are { $want }
heard-lens-shape = the disparity map cannot be used — it is { $map } pixels where the photo is { $photo }, which is another shape — give the map of this photo
heard-no-views = this needs all views, and only one map was made — make the light field first
heard-corners-large = 64 views of { $width }×{ $height } pixels do not fit into memory — give the four to `plenoscope synth --corners`, which makes smaller ones

# A file is not written.
heard-save-is-folder = the picture cannot be saved — there is a folder of that name — give the name of a file
heard-save-no-folder = the picture cannot be saved — its folder does not exist — make it first, or choose another
heard-save-in-the-way = the folder cannot be made — there is a file of that name — choose another name
heard-save-is-link = the folder cannot be made — there is a symbolic link of that name, which is not followed — name the folder that it leads to
heard-save-name = the picture cannot be saved — its name is too long, or has letters that the disk does not take — choose a shorter one
heard-save-is-source = the picture would replace the photo that it is made from — choose another name, or ask for it (--force)
heard-save-exists = the picture is not saved — a file of that name came there meanwhile — choose another name
heard-save-no-rights = the picture cannot be saved — writing is not allowed there — choose another folder
heard-save-disk-full = the picture cannot be saved — the disk is full — make room, or choose another disk
heard-save-disk = the picture cannot be saved — the disk does not take it ({ $why }) — see whether it is still connected, or choose another
heard-save-extension = the picture cannot be saved — its name names no format — end it in .png, .jpg, .tif or .webp
heard-save-animation = the animation cannot be saved — its name names no format — end it in .gif, .webp, .png, .apng, .mp4 or .webm
heard-save-encode = the picture cannot be saved — { $why }
heard-link = there is a symbolic link of that name

# A net does not work.
heard-model-not-embedded = this program was built without { $path } — put the models into models/ and build again, or name a folder with --models
heard-model-unreadable = a model's file cannot be read — { $why } — choose a folder with models.toml and its models
heard-model-manifest = a model's manifest is not valid — { $why } — correct it
heard-model-tampered = model { $id } is not the file its manifest describes — its checksum differs — fetch the model again
heard-model-engine = model { $id }
heard-model-shape = model { $id } does not fit its manifest — it answers { $got } where { $want } is needed — correct one of them
heard-model-no-map = model { $id } does not answer with one depth map — its answer has the shape { $got } — export it with one output [1, 1, H, W]
heard-model-no-source = there is no ray depth from { $name } — known are { $known } — name one of them, or add the net with `plenoscope models add FILE.onnx`
heard-model-no-corners = there are no nets of four corners called { $name } — known are { $known } — leave --source out, or export such nets and name their folder with --models
heard-model-not-finite = model { $id } answers with values that are not numbers — its weights are damaged — fetch the model again
heard-memory = the light field needs { $number } MiB of memory — { $free } MiB are free — choose a long side of { $side } pixels or less
heard-threads = worker threads could not be started — { $why } — close other programs or use fewer threads
heard-engine-parse = the model cannot be read — it is no ONNX file or it is damaged ({ $detail }) — get it again
heard-engine-unsupported = the model cannot be used — it asks for something that is not supported ({ $detail }) — export it anew
heard-engine-operator = the model cannot be used — its operation { $name } is not supported — take a file of the same net without it, in float32 if there is one
heard-engine-external = the model's weights are not whole — its file { $name } is not beside it — put it there, named like that
heard-engine-inputs = the model cannot be used — its inputs are { $names }, and one picture is what it can be given — take a file with one input, or give the others numbers in its manifest (extra_inputs)
heard-engine-input = the model's input { $name } cannot be given a number — { $why } — take it out of extra_inputs
heard-engine-port = the model has no { $what } named { $name } — it has { $known } — correct its manifest
heard-engine-shape = the model does not take an input of { $shape } ({ $detail }) — check the inputs in its manifest
heard-engine-not-finite = the model's weights { $name } are not all finite numbers — its training failed — train or get it again
heard-engine-room = the net needs { $number } MiB of memory — { $most } MiB is what it may take here — take a smaller net or a smaller working size
heard-engine-run = the net stopped ({ $detail })
heard-engine-threads = no threads to run the net on — the system's limit is reached — close other programs
heard-adopt-engine = the net was not added — { $why }
heard-adopt-unreadable = the net was not added — reading it takes more memory or time than a net may — choose another file of that net
heard-adopt-no-picture = the net was not added — it takes no picture of three colours, its inputs are { $inputs } — choose a depth net
heard-adopt-pictures = the net was not added — it takes several pictures ({ $inputs }) — choose one that makes depth of one photo
heard-adopt-extra = the net was not added — besides the picture it wants { $name }, and nobody here knows what — export it without that input, or write its manifest by hand (models/MANIFEST.md)
heard-adopt-no-map = the net was not added — none of its outputs ({ $outputs }) can be a depth map — choose a depth net
heard-adopt-not-depth = the net was not added — of the sample photo, whose depth is known, it finds { $why } — choose a depth net, or add this one all the same with --force
heard-adopt-too-large = the net was not added — it has { $number } MB, and an ONNX file has 2,147 MB at most — choose one with its weights in a second file
heard-adopt-exists = there is a net named { $name } already — choose another name with --name, or replace it with --force
heard-adopt-name = a net cannot be named { $name } — { $why } — choose another name with --name
heard-adopt-unknown = there is no net named { $name } — { $known } — add one with `plenoscope models add FILE.onnx`
heard-adopt-read = the net cannot be read — { $why } — check that the file is there and whole
heard-adopt-write = the net was not added — { $why } — make room, or check that the folder can be written to

# Which depth is used.
heard-no-own-depth = This photo has no depth of its own, so the network's is used
heard-no-phone-depth = This photo has no depth of its own, so the network's depth is used
heard-no-own-map = There is no map for this photo, so the network's depth is used
heard-no-depth = { $what }, so the network's depth is used
heard-automatic = { $why } — the automatic choice is used
heard-own-net = { $why } — the program's own net is used
heard-own-depth = { $why } — the picture's own depth is used
heard-exchanged = What looks near to the depth net lies far in these views: if it is near, turn on “Exchange near and far”
heard-recorded-strength = A recorded light field reaches as far as its views do: its strength is 1 at most
heard-not-cached = The light field could not be kept for next time — { $why }

# Several photos.
heard-still = the camera did not move; one photo is used
heard-only-turned = the camera only turned, so that nothing can be measured; one photo is used — move it sideways by some centimetres
heard-unlike = the photos do not show the same things; one photo is used
heard-many-photos = { $number } photos are more than are needed: { $used } of them are used, evenly apart
heard-left-out = { $why } — it is left out
heard-left-out-shape = { $name } is left out — it has another shape than the first photo
heard-left-out-lens = { $name } is left out — it was taken with another lens or zoom than the first photo
heard-left-out-than = { $name } is left out — { $why } than the first photo
heard-photos-left-out = Photos that do not fit are left out
heard-one-usable = only one photo can be used; its other views are made
heard-no-photo-number = there is no photo { $wanted } — { $count } were given — name another as --reference

# Pictures that carry their edit.
heard-will-not-know = The picture will not know its photo: { $why }
heard-map-stays = A map of your own does not go into the picture: name it again with its edit
heard-photo-stays = The photo does not go into the picture: its file says where it was taken, which is to be left out
heard-carries-none = this picture carries no edit — it was not exported with one — name a recipe
heard-carries-bad = the edit in this picture cannot be used — { $why } — open the photo itself
heard-photo-missing = the photo that this picture was made of is not beside it — { $name } was moved or changed — put it into the same folder
heard-page-holds = the page holds { $width } × { $height } of { $all-width } × { $all-height } pixels, as it is to stay below 3 MB
heard-page-lens = the page has a round lens without faults and grain

# Recipes, lenses, scales.
heard-lens-file = this lens cannot be used — { $why } — a lens has name, focal_mm, f_numbers, and may have blades and nearest_m
heard-recipe-read = the recipe cannot be read — { $why }
heard-recipe-parse = this recipe cannot be used — { $why } — make one with "Copy edit" or write the sidecar of a photo anew
heard-no-scale = { $name } is no scale of depth: use deep or lytro
heard-no-trainer = the trainer is not here — it is a program of its own — build it with `cargo build --release --package plenoscope-train` and put plenoscope-train beside plenoscope
heard-trainer-start = the trainer does not start — { $why }

# What files say of themselves.
heard-hci-grid = parameters.cfg is missing, so the number of views tells the grid
heard-disparity-left-out = the disparity is left out — { $why }
heard-disparity-of-view = the disparity is left out — it is that of view (v { $v }, u { $u })
heard-quilt-views = { $number } of the quilt's { $count } views are used, at even distances
heard-camera-left-out = its camera is left out — its numbers are those of no camera
heard-encoder-failed = the encoder failed
heard-film-cut-off = the film is cut off — what lies before its end is used
heard-harmonics-left-out = harmonics beyond degree { $degree } are left out
heard-laid-out = the views were laid out anew, because they fit together better so
heard-depths-left-out = the ray depths are left out — { $why }
heard-table-left-out = the depth table is left out — { $why }
heard-original-left-out = the all-in-focus original is left out — { $why }
heard-profile-unusable = the colour profile cannot be used, so the colours are taken as sRGB
heard-profile-unreadable = the colour profile cannot be read, so the colours are taken as sRGB
