# Plenoscope in Deutsch. How a text is added, and how a language: CONTRIBUTING.md.
# { $name } is put in; numbers come with the decimals that they are to have.

language-name = Deutsch
# `leftward` where it is read from right to left.
reading = rightward
number-decimal = ,
number-group = .

## Units behind numbers.
suffix-px = {" "}px
suffix-px-view = {" "}px/Ansicht
suffix-m = {" "}m
suffix-s = {" "}s
language-unreadable = eine Sprache kann nicht gelesen werden — sie ist keine Textdatei, öffnet zu viele Klammern in einem Text, oder ihr Name ist der keiner Sprache — nennen Sie sie wie de.ftl oder pt-BR.ftl: { $path }
language-damaged = { $count ->
    [one] Ein Text einer Sprache kann nicht gelesen werden, in Zeile { $line }: { $path }
   *[other] { $count } Texte einer Sprache können nicht gelesen werden, der erste in Zeile { $line }: { $path }
}
depths-view = Ansicht ({ $v }, { $u })
depths-readout = x { $x }, y { $y } · { $view } · { $disparity } px/Ansicht
points-none = Die Punkte kommen mit dem Lichtfeld
points-canvas = Punktfläche
points-readout = { $count } Punkte · gedreht um { $yaw }°, { $pitch }° · { $zoom } ×
points-filling = { " " }· was andere Ansichten sehen, kommt dazu

## Nothing is open.
empty-title = Legen Sie ein Foto hier ab, um hineinzusehen
empty-promise = Aus einem Foto wird ein Lichtfeld: umsehen, überall scharfstellen, die Blende öffnen
open = Öffnen…
paste = Einfügen
try-sample = Beispiel ansehen
recent = Zuletzt geöffnet
drop-instead = Loslassen, um stattdessen dies zu öffnen
drop = Loslassen zum Öffnen

## The top bar.
face = Darstellung
face-picture = Bild
face-views = Ansichten
face-depths = Strahltiefen
face-points = Punkte
export-open = Exportieren…
before-after = Vorher / nachher
inspector = Inspektor

## The status line.
others-more = · { $count } weitere
queue-name = Warteschlange
drawn-by = gezeichnet von { $device }
drawn-by-threads = gezeichnet von { $device } · Netze auf { $threads ->
    [one] 1 CPU-Thread
   *[other] { $threads } CPU-Threads
 }
zoom = Zoom { $percent } %
idle-nothing = Alles bleibt auf diesem Computer
idle-photo = Ziehen: umsehen · Klick: scharfstellen · Mausrad: Zoom · F1: alle Tasten
idle-field = Ziehen: umsehen · Mausrad: Zoom · F1: alle Tasten
idle-flat = Kein Lichtfeld · Mausrad: Zoom
esc-stops = { $time } · Esc bricht ab

## Which source of depth is looked at.
source-made = { $name } wird berechnet · { $number } von { $count } · S weiter · Esc zurück
source-compared = { $name } · { $number } von { $count } · S weiter · Umschalt+S übernimmt sie · Esc zurück
source-alone = { $name } · S vergleicht { $count } Quellen
the-processor = dem Prozessor
no-device = keinem Gerät

## The export dialog.
export-photos = { $count ->
    [one] Ein Foto
   *[other] { $count } Fotos
 } exportieren
export = Exportieren
cancel = Abbrechen
eyes-apart = Augenabstand
suffix-views = { " " }Ansichten
more-is-deeper = mehr ist tiefer
display = Display
quilt-holds = { $count } Blickpunkte in { $cols } × { $rows } Kacheln, { $width } × { $height } px
holds = Enthält
views-of = { $cols } × { $rows } Ansichten mit { $width } × { $height } px
size = Größe
size-of-views = { $width } × { $height } px, wie die Ansichten
frames = Einzelbilder
suffix-a-second = { " " }pro Sekunde
seconds = { $secs } s
moves = Bewegung
fits-into = Passt in
format = Format
long-side = Lange Seite
photo = Foto
pixels = { $width } × { $height } px
quality = Qualität
bit-depth = Farbtiefe
bits-8 = 8 Bit
bits-16 = 16 Bit
metadata = Metadaten
keep-all = Alle behalten
without-place = Ohne den Ort
drop-all = Alle weglassen
inside = Im Bild
inside-nothing = Nichts geht mit, wenn alle Metadaten wegfallen
inside-edit = Bearbeitung
inside-edit-hint = Das Bild weiß, wie es entstand: Wieder geöffnet, sind Foto und Bearbeitung zurück
inside-depth = Tiefe
inside-depth-hint = Die Tiefenkarte, wie Telefone sie schreiben (GDepth)
inside-photo-hint = Die Datei des Fotos selbst, sodass die Bearbeitung sonst nichts braucht
name = Name
name-hint = {"{name}"}, {"{f}"} und {"{focus}"} werden eingesetzt
folder = Ordner
choose = Auswählen…
beside-photo = Neben dem Foto
beside-photo-hint = Neben jedes Foto schreiben
if-it-exists = Falls vorhanden
exists-number = Nummer anhängen
exists-replace = Ersetzen
exists-leave = Nicht ändern
writes = Schreibt

## The settings.
settings = Einstellungen
language = Sprache
language-system = Wie das System ({ $name })
theme = Erscheinung
theme-dark = Dunkel
theme-light = Hell
theme-system = Wie das System
light-field = Lichtfeld
long-side-px = { $side } px
occlusions = Verdeckungen
occlusions-correct = Vom zweiten Netz korrigieren lassen
edits = Bearbeitungen
edits-hint = Eine kleine Datei neben jedem Foto: foto.jpg.plenoscope.json
edits-keep = Neben den Fotos aufbewahren
models = Modelle
built-in = Eingebaute
models-own = die im Programm
done = Fertig

## Where ray depths come from.
source-network = Netz
section-source = Quelle der Strahltiefen
link-depth-map = Tiefenkarte…
link-compare = vergleichen
source = Quelle
model = Modell
model-built-in = eingebautes
add-net-hint = Eine ONNX-Datei: Sie wird am Beispiel geprüft und behalten. Man kann sie auch auf das Fenster ziehen
add-net = Tiefennetz hinzufügen…
use-for-all = Für alle Fotos verwenden
remove-net = { $name } entfernen
section-light-field = Lichtfeld
views-count = { $cols } × { $rows } Ansichten
made-by = Berechnet mit
from-disk = von der Festplatte
took = Dauer
views-lie = Anordnung

## Depth mended by hand.
section-repair = Reparieren
link-done = fertig
link-mend = reparieren
repair-tool = Reparaturwerkzeug
repair-brush = Reparaturpinsel
brush = Pinsel
brush-hint = Sein Durchmesser, von der längeren Seite. Mausrad
brush-strength = Stärke
brush-strength-hint = Wie viel ein Strich bewirkt
reach-hint = Wie weit das Objekt vom Klick aus reicht, von der längeren Seite. Mausrad
reach = Reichweite
by = Um
by-hint = Um wie viel Näher und Ferner das Objekt verschieben
nearer = Näher
nearer-hint = Das ganze Objekt kommt näher
farther = Ferner
farther-hint = Das ganze Objekt rückt weiter weg
flatten = Abflachen
flatten-hint = Eine Karte, die der Kamera zugewandt ist
stand = Aufstellen
stand-hint = Eine senkrechte Ebene auf dem Fuß des Objekts
lie = Hinlegen
lie-hint = Ein Teil des Bodens um das Objekt
join = Anschließen
join-hint = Die Tiefe des Nachbarn, der in denselben Farben weitergeht
draw-round = Umfahren Sie ein Objekt im Bild
click-thing = Klicken Sie ein Objekt im Bild an; das Mausrad vergrößert die Auswahl
repair-unknown = Dieser Version unbekannt
repair-remove-hint = Diese Reparatur entfernen
repair-remove = Reparatur { $number } entfernen

## The shape of the opening.
opening-own-hint = Ein eigenes Bild: Weiß ist offen
opening-own = Bild…
disc = Scheibe
disc-hint = Ein rundes Objektiv
square = Quadrat
square-hint = Das Quadrat der Ansichten des Lichtfelds
blades = Lamellen
blades-hint = Ein Vieleck aus geraden Lamellen
ring = Ring
ring-hint = Ein Spiegelobjektiv
cats-eye = Katzenauge
cats-eye-hint = Eine Scheibe, zu den Ecken hin vom Tubus beschnitten
opening-picture = Bild
opening-picture-hint = Ein eigenes Bild
blade-count = Lamellen
blade-count-hint = Gerade Kanten
rotation = Drehung
rotation-hint = Dreht die Lamellen
roundness = Rundung
roundness-hint = 0 gerade, 1 eine Scheibe
hole = Loch
hole-hint = Radius des Lochs im Spiegel
cats-eye-strength = Katzenauge
cats-eye-strength-hint = Wie viel der Tubus in den Ecken abschneidet
opening-preview = Die Öffnung: Licht hinter der Schärfeebene nimmt diese Form an

## What else a lens does.
anamorphic = Anamorphot
anamorphic-hint = Scheiben höher als breit: 1 ist doppelt so hoch
spherical = Sphärisch
spherical-hint = Scheiben hinter der Schärfeebene: 1 heller Rand, −1 helle Mitte
fringes = Farbsäume
fringes-hint = Ränder grün hinter der Schärfeebene, magenta davor
swirl = Wirbel
swirl-hint = Scheiben zu den Ecken hin beschnitten und eine gewölbte Schärfefläche
section-glass = Glas

## A box for a path.
path-open = Öffnen
path-open-what = ein Foto oder Lichtfeld
path-export = Fotos exportieren
path-export-what = ein Foto
path-depth = Tiefenkarte
path-depth-what = eine PFM-Datei oder ein Graubild
path-opening = Öffnung des Objektivs
path-opening-what = ein Bild; Weiß ist offen
path-models = Modelle
path-models-what = einen Ordner mit Modellen
path-net = Tiefennetz
path-net-what = eine ONNX-Datei
path-fields = Lichtfelder zum Trainieren
path-fields-what = einen Ordner mit Lichtfeldern
verb-open = Öffnen
verb-go-on = Weiter
verb-use = Verwenden
verb-add = Hinzufügen
path-ask = Das System zeigt hier keinen Dateidialog. Geben Sie den Pfad ein oder fügen Sie ihn ein für { $what }
path-none = nichts geöffnet — das ist kein Pfad einer Datei — beginnen Sie ihn mit / oder ~

## Presets.
presets = Vorgaben
presets-none = Noch keine: Objektiv und Export werden unter Ihrem Namen aufbewahrt
presets-some = Objektiv und Export; der Fokus bleibt
preset-name = Name einer neuen
keep = Behalten
close = Schließen
remove = Entfernen
apply = Anwenden

## The queue.
clear-ended = Beendete entfernen
add-photos = Fotos hinzufügen…
queue-empty = Es wird nichts exportiert
show-in-folder = Im Ordner zeigen
stop = Anhalten
waits = wartet
task-done = fertig
was-there = war schon da
stopped = angehalten

## The lens in a photographer's numbers.
section-real-lens = Echtes Objektiv
distance-tip = Mit einer Entfernung liest sich das Objektiv in Metern; das Fernste gilt als sehr weit weg
distance-give = Entfernung des Scharfen angeben
distance = Entfernung
distance-hint = Wie weit das Scharfe entfernt ist
distance-forget = Entfernung vergessen
length-give = oder die Länge von etwas darin
length-tip = Eine Linie über etwas ziehen, dessen Länge bekannt ist: Daraus folgt, wie weit es entfernt ist
length-draw = im Bild von einem Ende zum anderen ziehen
length = Länge
length-hint = Wie lang es ist; seine Entfernung folgt aus der Brennweite
length-done = die Linie wegnehmen
open-as = öffnen wie … ▼
lens-blades = { " " }· { $count } Lamellen
lens-nearest = { " " }· ab { $metres } m
lens-cut = Die Blende von { $lens } ist weiter, als es hier geht: { $reading }

## How deep the scene is.
strength-hint = Wie tief die Szene ist: der Abstand der Ansichten, verglichen mit dem ursprünglichen
strength-hint-field = Wie weit die Ansichten auseinanderliegen; bei einem aufgenommenen Lichtfeld nicht weiter als sie waren
strength = Tiefenstärke
strength-slider = Regler für die Tiefenstärke
baseline-reach = Die Strahlen reichen über { $percent } % der Basis
baseline-reach-hint = Wie weit die äußersten Ansichten vom ersten Foto entfernt sind, verglichen mit der Kamera; die Tiefenstärke stellt es ein

## The views.
views = Ansichten
views-all = alle { $count } ▶
all-views = Alle Ansichten
view-at = Ansicht { $v }, { $u }
view-step = u { $u }, v { $v }

## Which end of a map is near.
near-end-title = Auf welchem Bild ist Nahes gelb?
near-end-ask = { $name } sagt nicht, welches Ende der Werte nah ist. Klicken Sie auf das richtige Bild
near-large = Große Werte sind nah
near-small = Kleine Werte sind nah
near-likely = { $name } · wahrscheinlich

## How bright the picture is.
section-histogram = Histogramm
clipped = { $dark } Tiefen · { $bright } Lichter beschnitten
histogram-said = Histogramm, { $text }
percent = { $share } %
percent-below = < { $share } %

## Told once.
got-it = Verstanden
hint-look = Ziehen Sie am Bild, um sich umzusehen
hint-focus = Klicken Sie auf das, was scharf sein soll
hint-export = Exportieren speichert das Bild, wie Sie es sehen

## Several files at once.
files-count = { $count ->
    [one] 1 Datei
   *[other] { $count } Dateien
 }
and-more = und { $count } weitere
many-ask = Fotos eines Motivs, von leicht verschiedenen Stellen aufgenommen – oder jedes für sich?
one-subject-hint = Freihändig von leicht verschiedenen Stellen aufgenommen: Die Tiefe wird gemessen, und was eines verdeckt, zeigt ein anderes
one-subject = Ein Motiv
take-mean = Weniger Rauschen: Mittel der Fotos
take-mean-hint = Wo die anderen dasselbe zeigen, nimmt das erste Foto das Mittel aller; sonst bleibt es, wie es ist
open-first = Erstes öffnen
export-all-hint = Jedes wird ein Lichtfeld und mit dem jetzt eingestellten Objektiv geschrieben
export-all = Alle exportieren…

## The shortcut sheet.
shortcuts = Tasten
mouse = Maus

## The depth ruler.
ruler-far = fern
ruler-near = nah
depths-coming = Strahltiefen sind unterwegs
depths-none = keine Strahltiefen
ruler-hint = Tiefenlineal: Ziehen stellt scharf, an den Rändern des Bands ziehen hält mehr scharf
focus = Fokus
sharp-far-edge = Scharf halten, ferne Kante
sharp-near-edge = Scharf halten, nahe Kante
zero-px-view = 0 px/Ansicht

## Epipolar images.
epi-row = EPI u · Zeile { $row }
epi-column = EPI v
slope = Steigung
px-view = px/Ansicht
the-row = der Zeile
the-column = der Spalte
repair-canvas = Reparaturfläche
slope-of = Steigung { $line }

## The ray depths' face.
no-depths-yet = Noch keine Strahltiefen
depths-canvas = Strahltiefenfläche

## The picture.
picture-canvas = Bildfläche
split-photo = Foto
split-refocused = Nachfokussiert
kept-sharp = Scharf gehalten { $number }
readout-place = x { $x }, y { $y }
readout-view = { " " }· Ansicht ({ $u }; { $v })
readout-depth = { " " }· { $disparity } px/Ansicht

## The inspector.
section-lens = Objektiv
peaking = Fokus-Peaking
trust = Erfundenes zeigen
invented-most = Höchstens erfunden
invented-most-hint = Wie viel vom Bild erfunden sein darf: die Marken an Blende und Feld
aperture = Blende
aperture-hint = Wie weit sich das Objektiv öffnet
aperture-slider = Blendenregler
aperture-beyond = Jenseits von f/{ $f } ist mehr als { $percent } % des Bilds erfunden
synthetic-hint = Synthetisch: weiter als das Lichtfeld
synthetic = synthetisch: weiter als das Lichtfeld
focus-number = Fokus
focus-hint = Disparität, die scharf ist
keep-sharp = Scharf halten
keep-sharp-hint = Tiefen um den Fokus, die auch scharf bleiben · Doppelklick setzt zurück
sharp-nearer = Scharf halten, näher
sharp-nearer-hint = Zum Auge hin
sharp-farther = Scharf halten, ferner
sharp-farther-hint = Vom Auge weg
tilt-across = Neigung quer
tilt-across-hint = Schärfeebene: Zunahme vom linken Rand zum rechten
tilt-down = Neigung längs
tilt-down-hint = Schärfeebene: Zunahme vom oberen Rand zum unteren
highlights = Spitzlichter
highlights-hint = Hellt beschnittene Lichter auf, bevor sie unscharf werden (in Fotogröße)
grain = Korn
grain-hint = Gibt dem Unscharfen das Korn des Fotos zurück (in Fotogröße)
section-viewpoint = Blickpunkt
link-centre = Mitte ↺
link-stop-circle = Kreis anhalten
link-circle = ▶ Kreis
drag-to-look =
    am Bild ziehen,
    um sich umzusehen
step-hint = Schritte vom Ort der Aufnahme
pivot-hint = Die Disparität dessen, was beim Umsehen an seiner Stelle bleibt; Strg-Klick setzt sie
pivot = Drehpunkt
pad = Blickpunktfeld
pad-hint = Klicken oder ziehen: wo das Auge ist. Hellere Felder enthalten weniger Erfundenes, die innerhalb der Linie nicht mehr als eingestellt. Umschalt: zwischen Ansichten
section-depths = Strahltiefen
depths-picture = Bild der Strahltiefen
depths-far = fern { $disparity }
depths-near = nah { $disparity }

## The timeline.
preset-pull = Schärfefahrt
    .hint = Der Fokus, von fern nach nah
preset-subjects = Von Motiv zu Motiv
    .hint = Der Fokus, vom Scharfen zum nächsten und zurück
preset-circle = Kreis
    .hint = Das Auge, einmal herum
preset-breathing = Atmen
    .hint = Das Objektiv blendet ab und wieder auf
preset-dolly = Dolly-Zoom
    .hint = Die Tiefenstärke wächst um ein Motiv, das scharf bleibt
film-stop = Anhalten
film-play = Abspielen
set-key = Schlüsselbild ändern
add-key = Schlüsselbild setzen
remove-key = Schlüsselbild entfernen
hold-focus = Fokus
hold-aperture = Blende
hold-eye = Auge
hold-strength = Tiefenstärke
key-holds = Hält fest
key-holds-hint = Was ein neues Schlüsselbild festhält
film-presets = Vorgaben
film-none = Keine
film-none-hint = Alle Schlüsselbilder entfernen
ease-smooth = Weich
ease-even = Gleichmäßig
ease-in = Langsam los
ease-out = Langsam aus
easing = Übergang
run-once = Einmal
run-loop = Schleife
run-ping-pong = Hin und her
at-the-end = Am Ende
seconds-hint = Wie lang der Film ist
film-seconds = Sekunden
chosen-said = { $name }: { $value }
playhead = Abspielposition, Sekunden
timeline-empty = Objektiv und Auge einstellen, Schlüsselbild setzen; auf der Linie weitergehen und das nächste setzen
key-said = Schlüsselbild { $number } bei { $secs } s: { $what }

## A net that was added.
added-title = { $name } hinzugefügt
the-sample = Das Beispiel
its-depth = Seine Tiefe laut diesem Netz
use-for-all-hint = Für jedes Foto ohne eigene Tiefe

## The program broke off.
broke-title = Ein Fehler in Plenoscope
go-on = Weiter
copy-report = Bericht kopieren
hide-report = Bericht verbergen
show-report = Bericht zeigen
broke-told = Beim letzten Mal ist etwas schiefgegangen. Ein Bericht liegt auf diesem Rechner: Er enthält kein Bild und von Dateien nur die Namen. Nichts wurde gesendet. Er hilft, den Fehler zu beheben.

## What happened, in a corner.
saved = { $name } gespeichert
less = Weniger
details = Einzelheiten
licence-unknown = unbekannt: Sehen Sie nach, woher Sie es haben
unknown = unbekannt
fact-family = Familie
fact-size = Größe
megabytes = { $size } MB
fact-time = Zeit
seconds-a-photo = { $secs } s pro Foto
fact-licence = Lizenz
fact-order = Reihenfolge der Tiefe im Beispiel
correlation = Korrelation { $value }
no-folder-for-nets = das System nennt keinen Ordner für Netze — setzen Sie HOME — und fügen Sie es dann wieder hinzu

## Names of sources of depth.
source-gaussians = Gauß-Splats
source-photos = { $count } Fotos
source-map = Eigene Karte
source-phone = Telefon
source-fused = Vereint

## What screen readers are told.
said-layer = Tiefenebene { $number } von { $count }, f/{ $f }
said-left = , { $steps } links
said-right = , { $steps } rechts
said-up = , { $steps } oben
said-down = , { $steps } unten
said-runs = { $stage }, { $percent } Prozent
plane-leans = die Schärfeebene neigt sich durch alle Ringe
plane-none = keine Ebene geht durch die Ringe: Ein Band von Tiefen hält sie scharf

## What was opened.
was-made-of = { $picture } wurde aus { $photo } gemacht: Hier ist es, mit dieser Bearbeitung
size-only = { $width } × { $height }
bits = { $bits } Bit
phone-depth = Telefontiefe gefunden
progress-of = { $stage } · { $done } von { $total }
time-left = { $elapsed } · noch { $left }
minutes = { $minutes } min
one-source = Dieses Foto hat nur eine Tiefenquelle: Ziehen Sie ein Tiefennetz (.onnx) auf das Fenster, um eine zweite zu haben
presets-no-folder = Vorgaben können nicht aufbewahrt werden — das System nennt keinen Ordner für Einstellungen — setzen Sie HOME
paste-no-edit = nichts einzufügen — die Zwischenablage enthält keine Bearbeitung — kopieren Sie zuerst eine von einem anderen Foto (Bearbeitung kopieren)
paste-nothing = nichts einzufügen — die Zwischenablage enthält kein Bild und keinen Dateipfad — kopieren Sie zuerst ein Bild oder einen Pfad
paste-no-answer = nichts eingefügt — die Zwischenablage des Systems antwortet nicht — öffnen Sie stattdessen die Datei
keys-most = kein Schlüsselbild gesetzt — die Zeitleiste hat schon { $most } — entfernen Sie zuerst eines
device-lost = Das Grafikgerät ging verloren. Das Bild und seine Bearbeitung sind wieder da.
edited-elsewhere = Dieses Foto wurde inzwischen anderswo bearbeitet; jene Bearbeitung liegt unter { $name }
edit-not-kept = die Bearbeitung liegt nicht neben dem Foto — { $why } — kopieren Sie das Foto in einen eigenen Ordner, oder schalten Sie dies in den Einstellungen ab
left-as-it-was = { $name } ist schon da und blieb, wie es ist
copied-picture = Bild kopiert, { $width } × { $height } px
other-shape = diese Tiefenkarte gehört nicht zu diesem Foto — sie hat andere Seitenverhältnisse — verwenden Sie eine mit denen des Fotos
no-folder-dialog = Das System zeigt hier keinen Ordnerdialog: Tippen Sie den Ordner in das Feld
preset-applied = Vorgabe auf Objektiv und Export angewendet
edit-copied = Bearbeitung kopiert: Fügen Sie sie bei einem anderen Foto ein
edit-no-photo = die Bearbeitung kann nicht angewendet werden — nichts ist offen — öffnen Sie zuerst ein Foto
edit-applied = Bearbeitung angewendet
nothing-to-export = noch nichts zu exportieren — das Lichtfeld wird noch berechnet — warten Sie, bis es fertig ist
stereo-anaglyph = Beide Augen in einem Bild, für Rot-Cyan-Brillen
stereo-parallel = Beide Augen nebeneinander, linkes Auge links
stereo-crossed = Beide Augen nebeneinander, linkes Auge rechts: zum Schielen
stereo-off = Ein Bild für beide Augen
tool-thing = Objekt
tool-lasso = Lasso
tool-nearer = Näher
tool-farther = Ferner
tool-smooth = Glätten
tool-edge = Kante
photo-last = Das ist das letzte Foto des Ordners
photo-first = Das ist das erste Foto des Ordners
folder-unreadable = der Ordner konnte nicht durchgesehen werden — { $why } — prüfen Sie, ob Sie ihn lesen dürfen: { $folder }
repair-refused = dies kann nicht repariert werden — es liegt neben dem Foto, oder es sind schon { $most } Reparaturen da
job-broke = die Arbeit brach ab — ein Fehler im Programm ({ $what }) — versuchen Sie es noch einmal und melden Sie ihn, falls er wiederkommt
resets = { $hint } · Doppelklick setzt zurück
pasted-picture = Eingefügtes Bild

## Menu and tool tips: what can be done.
menu-file = Datei
menu-edit = Bearbeiten
menu-viewpoint = Blickpunkt
menu-film = Film
menu-view = Ansicht
menu-light-field = Lichtfeld
menu-help = Hilfe
command-open = Öffnen…
    .hint = Ein Foto oder ein Lichtfeld öffnen
command-open-folder = Ordner öffnen…
    .hint = Einen Ordner mit Ansichten öffnen
command-open-sample = Beispiel ansehen
    .hint = Das eingebaute Bild öffnen
command-paste = Einfügen
    .hint = Bild oder Pfad aus der Zwischenablage öffnen oder die Bearbeitung darin anwenden
command-previous-photo = Voriges Foto
    .hint = Das Foto vor diesem öffnen
command-next-photo = Nächstes Foto
    .hint = Das Foto nach diesem öffnen
command-export = Exportieren…
    .hint = Das Bild speichern, oder was sonst daraus werden kann
command-export-photos = Fotos exportieren…
    .hint = Andere Fotos mit dieser Bearbeitung exportieren
command-queue = Warteschlange
    .hint = Was exportiert wird, und was wartet
command-settings = Einstellungen…
    .hint = Erscheinung, Sprache, Lichtfeld, Modelle
command-copy-picture = Bild kopieren
    .hint = Das Bild in die Zwischenablage legen
command-stop = Anhalten
    .hint = Anhalten, was läuft
command-quit = Beenden
    .hint = Das Fenster schließen
command-undo = Rückgängig
    .hint = Die letzte Bearbeitung zurücknehmen
command-redo = Wiederholen
    .hint = Die letzte Bearbeitung wiederherstellen
command-copy-edit = Bearbeitung kopieren
    .hint = Objektiv, Fokus und Blickpunkt in die Zwischenablage legen
command-paste-edit = Bearbeitung einfügen
    .hint = Die Bearbeitung aus der Zwischenablage anwenden
command-presets = Vorgaben…
    .hint = Objektiv und Export unter einem Namen
command-reset-lens = Objektiv zurücksetzen
    .hint = Zurück zu f/3,5, Fokus in der Mitte
command-reset-viewpoint = Blickpunkt in die Mitte
    .hint = Zurück zum Ort der Aufnahme
command-step-left = Schritt nach links
    .hint = Das Auge eine Ansicht nach links rücken
command-step-right = Schritt nach rechts
    .hint = Das Auge eine Ansicht nach rechts rücken
command-step-up = Schritt nach oben
    .hint = Das Auge eine Ansicht nach oben rücken
command-step-down = Schritt nach unten
    .hint = Das Auge eine Ansicht nach unten rücken
command-circle = Kreis
    .hint = Den Blickpunkt kreisen lassen
command-nearer = Nähere Ebene
    .hint = Auf die nächste nähere Tiefenebene scharfstellen
command-farther = Fernere Ebene
    .hint = Auf die nächste fernere Tiefenebene scharfstellen
command-film = Zeitleiste
    .hint = Die Schlüsselbilder eines Films zeigen oder verbergen
command-play-film = Abspielen
    .hint = Den Film zeigen oder beenden
command-add-key = Schlüsselbild setzen
    .hint = Objektiv und Auge an der Abspielposition festhalten
command-earlier = Früher
    .hint = Die Abspielposition zurückbewegen
command-later = Später
    .hint = Die Abspielposition vorwärtsbewegen
command-picture = Bild
    .hint = Das nachfokussierte Bild
command-views = Ansichten
    .hint = Alle Unterapertur-Ansichten des Lichtfelds
command-depths = Strahltiefen
    .hint = Strahltiefen der gegenwärtigen Ansicht
command-points = Punkte
    .hint = Die Szene als Punkte: Ziehen dreht sie, ein Doppelklick dreht sie zurück
command-toggle-depth = Strahltiefen ein und aus
    .hint = Zwischen Bild und Strahltiefen wechseln
command-before-after = Vorher / nachher
    .hint = Links der Linie das Foto, rechts das Bild
command-stereo = Beide Augen
    .hint = Rot-Cyan, nebeneinander, gekreuzt und aus
command-peaking = Fokus-Peaking
    .hint = Die Kanten markieren, die scharf sind
command-trust = Erfundenes zeigen
    .hint = Einfärben, was erfunden und nicht gesehen ist
command-fit = Einpassen
    .hint = Das ganze Bild zeigen
command-one-to-one = 1:1
    .hint = Ein Bildpunkt des Bilds für einen des Bildschirms
command-zoom-in = Vergrößern
    .hint = Näher heran
command-zoom-out = Verkleinern
    .hint = Weiter weg
command-toggle-inspector = Inspektor
    .hint = Die Leiste rechts zeigen oder verbergen
command-full-screen = Vollbild
    .hint = Den ganzen Bildschirm verwenden
command-next-theme = Erscheinung
    .hint = Dunkel, hell oder wie das System
command-clear-recent = Liste der Dateien leeren
    .hint = Die zuletzt geöffneten Dateien vergessen
command-own-depth = Tiefenkarte…
    .hint = Strahltiefen aus einer eigenen Karte nehmen
command-compare-sources = Quellen vergleichen
    .hint = Die nächste Quelle der Strahltiefen zeigen; Esc geht zurück
command-keep-source = Diese Quelle behalten
    .hint = Die verglichene Quelle verwenden
command-repair = Tiefe reparieren
    .hint = Von Hand ausbessern, was an der Tiefe falsch ist
command-opposite = Nah und fern tauschen
    .hint = Das Vorzeichen jeder Disparität umkehren
command-transpose = Zeilen und Spalten tauschen
    .hint = Zeilen von Ansichten sind Spalten
command-serpentine = Hin und her
    .hint = Jede zweite Zeile von Ansichten läuft rückwärts
command-train = Trainieren…
    .hint = Netze an eigenen Lichtfeldern trainieren
command-shortcuts = Tasten
    .hint = Alle Tasten, und was die Maus tut

## Training.
training = An eigenen Lichtfeldern trainieren
training-what = Wählen Sie einen Ordner mit Lichtfeldern: An ihnen werden die Netze der Arbeit trainiert und sind dann für Ihre Fotos da
training-choose = Ordner wählen…
training-start = Trainieren
training-pause = Pause
training-go-on = Weiter
training-use = Dieses Netz verwenden
training-sheet = Was die Netze aus eben gesehenen Lichtfeldern machen: Foto, wahre und eigene Strahltiefen, Epipolarbilder
training-said = Verluste: { $text }
training-waits = { $name }: noch nicht begonnen
training-begins = { $name }: wird vorbereitet…
training-runs = { $name }: Schritt { $step } von { $all }; das Fenster ist derweil frei
training-ends = { $name }: wird nach Schritt { $step } gesichert…
training-rests = { $name }: ruht nach Schritt { $step } von { $all }
training-another = es wird schon etwas anderes trainiert — halten Sie es zuerst an

## Keys that have names.
key-ctrl = Strg
key-shift = Umschalt
key-left = Links
key-right = Rechts
key-up = Oben
key-down = Unten
key-escape = Esc
key-home = Pos1
key-page-up = Bild auf
key-page-down = Bild ab
key-comma = Komma
key-period = Punkt

## What the mouse does.
mouse-drag = Am Bild ziehen
    .hint = Umsehen
mouse-click = Ins Bild klicken
    .hint = Dort scharfstellen
mouse-shift-click = Umschalt-Klick
    .hint = Auch dies scharf halten
mouse-ctrl-click = Strg-Klick
    .hint = Beim Umsehen hierum drehen
mouse-wheel = Mausrad
    .hint = Am Zeiger zoomen
mouse-pan = Mittlere Taste oder Leertaste + ziehen
    .hint = Das Bild verschieben
mouse-epipolar = In einem Epipolarbild ziehen
    .hint = Die Tiefe eines Objekts setzen
mouse-hold = \ halten
    .hint = Das Foto selbst zeigen
mouse-double-click = Doppelklick auf den Namen eines Werts
    .hint = Ihn zurücksetzen

## What the library says in English, as it says it: recognised, and said in the language of the window. A `number` is one.

# Stages of a job.
heard-stage-open = Öffnen
heard-stage-depth = Strahltiefen schätzen
heard-stage-warp = Ansichten berechnen
heard-stage-occlusion = Verdeckungen korrigieren
heard-stage-sweep = Strahltiefen messen
heard-stage-match = Fotos abgleichen
heard-stage-poses = Kameras finden
heard-stage-mean = Mittel der Fotos bilden
heard-stage-mend = Tiefe reparieren
heard-stage-refocus = Nachfokussieren
heard-stage-save = Speichern

# What can be exported.
heard-group-pictures = Bilder
heard-group-light-field = Lichtfeld
heard-group-depth = Tiefe
heard-picture = Bild
heard-picture-hint = Das nachfokussierte Bild in der Größe des Fotos
heard-focal-stack = Fokusreihe
heard-focal-stack-hint = Ein Ordner mit Bildern, scharfgestellt von fern nach nah, eins ganz scharf, und welches wo scharf ist
heard-animation = Animation
heard-animation-hint = Eine Schärfefahrt, eine aufgehende Blende oder eine Runde des Blickpunkts
heard-video = Video
heard-video-hint = Ein Film in AV1, MP4 oder WebM: eine Schärfefahrt, oder was die Zeitleiste sagt
heard-frames = PNG-Folge
heard-frames-hint = Ein Ordner mit jedem Einzelbild dieses Films als PNG, für Schnittprogramme
heard-living = Lebendiges Bild
heard-living-hint = Eine HTML-Datei zum Scharfstellen und Umsehen, in jedem Browser, ohne Verbindung
heard-side-by-side = Nebeneinander
heard-side-by-side-hint = Beide Augen nebeneinander, für 3-D-Bildschirme und -Brillen
heard-mpo = Stereopaar, MPO
heard-mpo-hint = Beide Augen als zwei JPEGs in einer Datei, für 3-D-Bildschirme und -Kameras
heard-spatial = Räumliches Foto
heard-spatial-hint = Beide Augen als räumliches Foto, ein HEIC, für 3-D-Brillen und Telefone
heard-anaglyph = Anaglyphenbild
heard-anaglyph-hint = Beide Augen in einem Bild, für Rot-Cyan-Brillen
heard-views = Ansichten mit Tiefe
heard-views-hint = Ein Ordner mit jeder Ansicht als PNG und ihren Strahltiefen als PFM; lässt sich so wieder öffnen
heard-eslf-hint = Ein Mikrolinsenbild, 14 × 14 Pixel je Linse, wie die Light Field Toolbox es liest
heard-hci = HCI-Ordner
heard-hci-hint = Wie die Szenen des 4-D Light Field Benchmark, mit Strahltiefen
heard-stanford = Stanford-Ordner
heard-stanford-hint = Nummerierte Ansichten, benannt wie im Stanford-Archiv
heard-quilt = Looking-Glass-Quilt
heard-quilt-hint = Viele Blickpunkte in einem Bild, für ein holografisches Display
heard-depth-png = Tiefenkarte, PNG
heard-depth-png-hint = 16-Bit-Grau, Weiß ist nah
heard-depth-pfm = Tiefenkarte, PFM
heard-depth-pfm-hint = Disparität in Pixeln pro Ansicht, jedes Bit behalten
heard-gdepth = Foto mit Tiefe
heard-gdepth-hint = Ein JPEG mit der Tiefe darin (GDepth), wie Telefone es schreiben
heard-ply = Punktwolke
heard-ply-hint = PLY: jedes Pixel als farbiger Punkt im Raum
heard-gaussians = Gauß-Splats
heard-gaussians-hint = PLY: eine Szene für Splat-Betrachter, eine Gaußfunktion für jeden gesehenen Punkt; lässt sich wieder öffnen

# What moves in a film.
heard-moves-focus = Fokus
heard-moves-focus-hint = Der Fokus, von fern nach nah
heard-moves-aperture = Blende
heard-moves-aperture-hint = Die Blende, von f/28 bis zur eingestellten
heard-moves-viewpoint = Blickpunkt
heard-moves-viewpoint-hint = Das Auge, einmal herum
heard-moves-subjects = Motive
heard-moves-subjects-hint = Der Fokus, vom Scharfen zum nächsten und zurück
heard-moves-breathing = Atmen
heard-moves-breathing-hint = Das Objektiv, das abblendet und wieder auf
heard-moves-dolly = Dolly-Zoom
heard-moves-dolly-hint = Die Tiefenstärke, um ein Motiv, das scharf bleibt
heard-moves-timeline = Zeitleiste
heard-moves-timeline-hint = Was die Zeitleiste sagt
heard-key-focus = Fokus
heard-key-aperture = Blende
heard-key-eye = Auge
heard-key-strength = Tiefenstärke

# Colours of ray depths.
heard-gray = grau

# Repairs.
heard-repair-nearer = Näher
heard-repair-farther = Ferner
heard-repair-flatten = Abflachen
heard-repair-stand = Aufstellen
heard-repair-lie = Auf den Boden legen
heard-repair-join = An den Nachbarn anschließen
heard-repair-to = In eine Tiefe rücken
heard-repair-brush-nearer = Pinsel: näher
heard-repair-brush-farther = Pinsel: ferner
heard-repair-brush-smooth = Glätten
heard-repair-brush-edge = Kante schärfen
heard-repairs-one = eine Reparatur dieser Bearbeitung ist nicht möglich — von einer späteren Version, neben dem Foto, mit unmöglichen Zahlen oder mehr als { $number } — der Rest ist getan, und die Datei behält alle
heard-repairs-some = { $count } Reparaturen dieser Bearbeitung sind nicht möglich — von einer späteren Version, neben dem Foto, mit unmöglichen Zahlen oder mehr als { $number } — der Rest ist getan, und die Datei behält alle
heard-repairs-other-photo = die Reparaturen dieser Bearbeitung gehören zu einem anderen Foto und bleiben weg — der Rest ist angewendet, und ihre Datei behält sie

# How the views of a light field lie.
heard-layout-as-is = wie sie sind
heard-layout-serpentine = jede zweite Zeile rückwärts
heard-layout-transposed = Zeilen und Spalten getauscht
heard-layout-flip-v = kopfüber
heard-layout-flip-u = seitenverkehrt
heard-made-by-own-depth = eigene Tiefe des Bilds

# The lens in a photographer's numbers.
heard-full-frame = Vollformat
heard-one-inch = 1 Zoll
heard-lens-title = { $number } mm f/{ $f } an { $format }
heard-lens-assumed = f/{ $f } an { $format }, falls mit { $number } mm aufgenommen
heard-lens-relative-title = { $title } · relativ, da keine Entfernung bekannt ist
heard-lens-relative = relativ: Hier ist keine Entfernung bekannt
heard-lens-focus = Fokus auf { $distance } · scharf { $range }
heard-lens-focus-far = Fokus sehr weit weg · scharf { $range }
heard-lens-hyperfocal = Hyperfokaldistanz { $distance }
heard-lens-blur = Unschärfe des Fernsten { $um } µm · { $px } px
heard-lens-none = das Foto nennt kein Objektiv: { $number } mm angenommen
heard-lens-range = { $near } … { $far }
heard-lens-from = ab { $near }
heard-lens-all-far = alles Ferne
heard-distance-mm = { $number } mm
heard-distance-cm = { $number } cm
heard-distance-m = { $number } m
heard-distance-km = { $number } km

# A depth net's licence.
heard-licence-large = die Gewichte von Large, Giant und Nested sind nur für nichtkommerzielle Nutzung
heard-licence-nobody = niemand sagt, wem seine Gewichte gehören
heard-licence-base = die Gewichte von Base und Large sind nur für nichtkommerzielle Nutzung
heard-licence-not-for-sale = seine Gewichte sind nur für nichtkommerzielle Nutzung
heard-licence-version = Version 2 dieser Gewichte ist nur für nichtkommerzielle Nutzung; Version 1 ist Apache-2.0

# A file does not open.
heard-stopped = angehalten
heard-read = die Datei konnte nicht gelesen werden — { $why } — prüfen Sie, ob sie da ist und ob Sie sie lesen dürfen
heard-empty = die Datei konnte nicht geöffnet werden — sie ist leer — kopieren Sie sie noch einmal von dort, woher sie kam
heard-unknown = die Datei konnte nicht geöffnet werden — sie ist kein Bild und kein Lichtfeld — öffnen Sie ein Foto (JPEG, PNG, WebP, TIFF, BMP, GIF, HEIC oder AVIF) oder ein Lichtfeld
heard-damaged = die { $format }-Datei konnte nicht geöffnet werden — { $why } — kopieren Sie sie noch einmal, oder speichern Sie sie neu mit dem Programm, aus dem sie stammt
heard-truncated = die { $format }-Datei konnte nicht geöffnet werden — sie ist abgeschnitten — kopieren Sie sie noch einmal von dort, woher sie kam
heard-unsupported = die { $format }-Datei konnte nicht geöffnet werden — { $why } — { $advice }
heard-too-long = die Datei konnte nicht geöffnet werden — sie hat { $number } KiB, höchstens { $most } KiB sind möglich — wählen Sie eine andere
heard-too-large = die Datei konnte nicht geöffnet werden — sie nennt { $width }×{ $height } Pixel, mehr als in { $number } MiB passen — verkleinern Sie sie zuerst
heard-implausible = die Datei konnte nicht geöffnet werden — sie nennt { $width }×{ $height } Pixel und hat nur { $number } KiB — kopieren Sie sie noch einmal, oder speichern Sie sie neu mit dem Programm, aus dem sie stammt
heard-missing-view = das Lichtfeld konnte nicht geöffnet werden — Ansicht (v { $v }, u { $u }) von { $rows }×{ $cols } fehlt — legen Sie die Datei in den Ordner zurück
heard-odd-view = das Lichtfeld konnte nicht geöffnet werden — eine Ansicht hat { $width }×{ $height } Pixel, die anderen { $others } — machen Sie alle Ansichten gleich groß
heard-bad-field = das Lichtfeld konnte nicht geöffnet werden — { $why } — machen Sie alle Ansichten noch einmal in einer Größe
heard-bad-opening = dieses Bild kann nicht die Öffnung eines Objektivs sein — { $why } — nehmen Sie ein kleines, in dem Weiß offen ist
heard-empty-folder = der Ordner konnte nicht geöffnet werden — er enthält kein Bild und kein Lichtfeld — wählen Sie einen anderen
heard-changed = das Foto hat sich geändert, seit es geöffnet wurde — seine Datei hat jetzt eine andere Größe — öffnen Sie es neu
heard-reduced = das Foto hat { $number } Megapixel — es wird mit { $width }×{ $height } gezeigt, und ein Bild wird so groß exportiert wie seine Datei
heard-too-large-for-it = sie ist zu groß für das, was sie sein soll
heard-is-folder = sie ist ein Ordner
heard-no-ordinary-file = sie ist keine gewöhnliche Datei
heard-no-text = sie ist kein Text in UTF-8
heard-no-such-file = Datei oder Ordner nicht vorhanden
heard-permission-denied = Zugriff nicht erlaubt
heard-field-grid = ein Lichtfeld hat 1 bis 17 Zeilen und Spalten von Ansichten, nicht { $rows }×{ $cols }
heard-field-length = { $what } hat { $number } Werte, wo die Größe { $most } braucht
heard-field-not-a-number = { $what } ist nicht verwendbar — es sind Werte darin, die keine Zahlen sind (NaN oder unendlich) — bessern Sie sie zuerst aus
heard-field-view-size = Ansicht ({ $v }, { $u }) hat { $got } Pixel, die anderen { $want }
heard-lens-shape = die Disparitätskarte ist nicht verwendbar — sie hat { $map } Pixel, das Foto { $photo }, andere Seitenverhältnisse — geben Sie die Karte dieses Fotos an
heard-no-views = dies braucht alle Ansichten, und es gibt nur eine Karte — berechnen Sie zuerst das Lichtfeld
heard-corners-large = 64 Ansichten mit { $width }×{ $height } Pixeln passen nicht in den Speicher — geben Sie die vier an `plenoscope synth --corners`, das kleinere macht

# A file is not written.
heard-save-is-folder = das Bild kann nicht gespeichert werden — ein Ordner heißt so — geben Sie den Namen einer Datei an
heard-save-no-folder = das Bild kann nicht gespeichert werden — sein Ordner ist nicht da — legen Sie ihn an, oder wählen Sie einen anderen
heard-save-in-the-way = der Ordner kann nicht angelegt werden — eine Datei heißt so — wählen Sie einen anderen Namen
heard-save-is-link = der Ordner kann nicht angelegt werden — ein symbolischer Verweis heißt so, dem nicht gefolgt wird — nennen Sie den Ordner, zu dem er führt
heard-save-name = das Bild kann nicht gespeichert werden — sein Name ist zu lang oder hat Zeichen, die die Platte nicht nimmt — wählen Sie einen kürzeren
heard-save-is-source = das Bild würde das Foto ersetzen, aus dem es gemacht ist — wählen Sie einen anderen Namen
heard-save-exists = das Bild ist nicht gespeichert — inzwischen ist dort eine Datei dieses Namens — wählen Sie einen anderen
heard-save-no-rights = das Bild kann nicht gespeichert werden — dort darf nicht geschrieben werden — wählen Sie einen anderen Ordner
heard-save-disk-full = das Bild kann nicht gespeichert werden — die Platte ist voll — schaffen Sie Platz, oder wählen Sie eine andere
heard-save-disk = das Bild kann nicht gespeichert werden — die Platte nimmt es nicht an ({ $why }) — sehen Sie nach, ob sie noch verbunden ist, oder wählen Sie eine andere
heard-save-extension = das Bild kann nicht gespeichert werden — sein Name nennt kein Format — er muss auf .png, .jpg, .tif oder .webp enden
heard-save-animation = die Animation kann nicht gespeichert werden — ihr Name nennt kein Format — er muss auf .gif, .webp, .png, .apng, .mp4 oder .webm enden
heard-save-encode = das Bild kann nicht gespeichert werden — { $why }
heard-link = ein symbolischer Verweis heißt so

# A net does not work.
heard-model-not-embedded = dieses Programm wurde ohne { $path } gebaut — wählen Sie in den Einstellungen einen Ordner mit Modellen
heard-model-unreadable = die Datei eines Modells ist nicht lesbar — { $why } — wählen Sie einen Ordner mit models.toml und seinen Modellen
heard-model-manifest = das Manifest eines Modells ist ungültig — { $why } — berichtigen Sie es
heard-model-tampered = Modell { $id } ist nicht die Datei, die sein Manifest beschreibt — die Prüfsumme weicht ab — holen Sie das Modell noch einmal
heard-model-engine = Modell { $id }
heard-model-shape = Modell { $id } passt nicht zu seinem Manifest — es antwortet mit { $got }, wo { $want } gebraucht wird — berichtigen Sie eines von beiden
heard-model-no-map = Modell { $id } antwortet nicht mit einer Tiefenkarte — seine Antwort hat die Form { $got } — exportieren Sie es mit einem Ausgang [1, 1, H, W]
heard-model-no-source = es gibt keine Strahltiefe von { $name } — bekannt sind { $known } — wählen Sie eine davon, oder fügen Sie das Netz hinzu
heard-model-no-corners = es gibt keine Netze für vier Ecken namens { $name } — bekannt sind { $known } — nennen Sie keine Quelle, oder exportieren Sie solche Netze und nennen Sie ihren Ordner
heard-model-not-finite = Modell { $id } antwortet mit Werten, die keine Zahlen sind — seine Gewichte sind beschädigt — holen Sie das Modell noch einmal
heard-memory = das Lichtfeld braucht { $number } MiB Speicher — { $free } MiB sind frei — wählen Sie eine lange Seite von höchstens { $side } Pixeln
heard-threads = Arbeits-Threads konnten nicht gestartet werden — { $why } — schließen Sie andere Programme, oder verwenden Sie weniger Threads
heard-engine-parse = das Modell ist nicht lesbar — es ist keine ONNX-Datei oder beschädigt ({ $detail }) — holen Sie es noch einmal
heard-engine-unsupported = das Modell ist nicht verwendbar — es verlangt etwas, das nicht unterstützt wird ({ $detail }) — exportieren Sie es neu
heard-engine-operator = das Modell ist nicht verwendbar — seine Operation { $name } wird nicht unterstützt — nehmen Sie eine Datei desselben Netzes ohne sie, möglichst in float32
heard-engine-external = die Gewichte des Modells sind unvollständig — seine Datei { $name } liegt nicht daneben — legen Sie sie unter diesem Namen dorthin
heard-engine-inputs = das Modell ist nicht verwendbar — seine Eingänge sind { $names }, und es bekommt nur ein Bild — nehmen Sie eine Datei mit einem Eingang, oder geben Sie den anderen im Manifest Zahlen (extra_inputs)
heard-engine-input = der Eingang { $name } des Modells kann keine Zahl bekommen — { $why } — nehmen Sie ihn aus extra_inputs
heard-engine-port = das Modell hat kein { $what } namens { $name } — es hat { $known } — berichtigen Sie sein Manifest
heard-engine-shape = das Modell nimmt keine Eingabe der Form { $shape } ({ $detail }) — prüfen Sie die Eingänge in seinem Manifest
heard-engine-not-finite = die Gewichte { $name } des Modells sind nicht alle endliche Zahlen — sein Training misslang — trainieren oder holen Sie es noch einmal
heard-engine-room = das Netz braucht { $number } MiB Speicher — { $most } MiB darf es hier nehmen — nehmen Sie ein kleineres Netz oder eine kleinere Arbeitsgröße
heard-engine-run = das Netz hielt an ({ $detail })
heard-engine-threads = keine Threads für das Netz — die Grenze des Systems ist erreicht — schließen Sie andere Programme
heard-adopt-engine = das Netz wurde nicht hinzugefügt — { $why }
heard-adopt-unreadable = das Netz wurde nicht hinzugefügt — es zu lesen braucht mehr Speicher oder Zeit, als ein Netz darf — wählen Sie eine andere Datei dieses Netzes
heard-adopt-no-picture = das Netz wurde nicht hinzugefügt — es nimmt kein Bild mit drei Farben, seine Eingänge sind { $inputs } — wählen Sie ein Tiefennetz
heard-adopt-pictures = das Netz wurde nicht hinzugefügt — es nimmt mehrere Bilder ({ $inputs }) — wählen Sie eines, das Tiefe aus einem Foto macht
heard-adopt-extra = das Netz wurde nicht hinzugefügt — außer dem Bild will es { $name }, und niemand weiß hier, was das ist — exportieren Sie es ohne diesen Eingang, oder schreiben Sie sein Manifest von Hand (models/MANIFEST.md)
heard-adopt-no-map = das Netz wurde nicht hinzugefügt — keiner seiner Ausgänge ({ $outputs }) kann eine Tiefenkarte sein — wählen Sie ein Tiefennetz
heard-adopt-not-depth = das Netz wurde nicht hinzugefügt — im Beispielfoto, dessen Tiefe bekannt ist, findet es { $why } — wählen Sie ein Tiefennetz, oder fügen Sie dieses auf der Kommandozeile mit --force doch hinzu
heard-adopt-too-large = das Netz wurde nicht hinzugefügt — es hat { $number } MB, und eine ONNX-Datei hat höchstens 2147 MB — wählen Sie eines mit den Gewichten in einer zweiten Datei
heard-adopt-exists = ein Netz namens { $name } gibt es schon — entfernen Sie es zuerst, oder benennen Sie die Datei um
heard-adopt-name = ein Netz kann nicht { $name } heißen — { $why } — benennen Sie die Datei um
heard-adopt-unknown = es gibt kein Netz namens { $name } — { $known } — fügen Sie eines hinzu
heard-adopt-read = das Netz ist nicht lesbar — { $why } — prüfen Sie, ob die Datei da und vollständig ist
heard-adopt-write = das Netz wurde nicht hinzugefügt — { $why } — schaffen Sie Platz, oder prüfen Sie, ob in den Ordner geschrieben werden darf

# Which depth is used.
heard-no-own-depth = Dieses Foto hat keine eigene Tiefe, daher gilt die des Netzes
heard-no-phone-depth = Dieses Foto hat keine eigene Tiefe, daher gilt die Tiefe des Netzes
heard-no-own-map = Für dieses Foto gibt es keine Karte, daher gilt die Tiefe des Netzes
heard-no-depth = { $what }, daher gilt die Tiefe des Netzes
heard-automatic = { $why } — die automatische Wahl gilt
heard-own-net = { $why } — das Netz des Programms gilt
heard-own-depth = { $why } — die eigene Tiefe des Bilds gilt
heard-exchanged = Was dem Tiefennetz nah scheint, liegt in diesen Ansichten fern: Wenn es nah ist, schalten Sie „Nah und fern tauschen“ ein
heard-recorded-strength = Ein aufgenommenes Lichtfeld reicht so weit wie seine Ansichten: Seine Tiefenstärke ist höchstens 1
heard-not-cached = Das Lichtfeld konnte nicht für das nächste Mal aufbewahrt werden — { $why }

# Several photos.
heard-still = die Kamera hat sich nicht bewegt; ein Foto wird verwendet
heard-only-turned = die Kamera hat sich nur gedreht, sodass nichts zu messen ist; ein Foto wird verwendet — bewegen Sie sie um einige Zentimeter seitwärts
heard-unlike = die Fotos zeigen nicht dasselbe; ein Foto wird verwendet
heard-many-photos = { $number } Fotos sind mehr, als gebraucht werden: { $used } davon gelten, in gleichen Abständen
heard-left-out = { $why } — es bleibt weg
heard-left-out-shape = { $name } bleibt weg — es hat andere Seitenverhältnisse als das erste Foto
heard-left-out-lens = { $name } bleibt weg — es wurde mit anderem Objektiv oder Zoom aufgenommen als das erste Foto
heard-left-out-than = { $name } bleibt weg — { $why } als das erste Foto
heard-photos-left-out = Fotos, die nicht passen, bleiben weg
heard-one-usable = nur ein Foto ist verwendbar; seine anderen Ansichten werden berechnet
heard-no-photo-number = es gibt kein Foto { $wanted } — { $count } wurden angegeben — nennen Sie ein anderes

# Pictures that carry their edit.
heard-will-not-know = Das Bild wird sein Foto nicht kennen: { $why }
heard-map-stays = Eine eigene Karte geht nicht in das Bild: Nennen Sie sie mit seiner Bearbeitung wieder
heard-photo-stays = Das Foto geht nicht in das Bild: Seine Datei sagt, wo es aufgenommen wurde, und das soll wegbleiben
heard-carries-none = dieses Bild enthält keine Bearbeitung — es wurde ohne eine exportiert — nennen Sie ein Rezept
heard-carries-bad = die Bearbeitung in diesem Bild ist nicht verwendbar — { $why } — öffnen Sie das Foto selbst
heard-photo-missing = das Foto, aus dem dieses Bild gemacht wurde, liegt nicht daneben — { $name } wurde verschoben oder verändert — legen Sie es in denselben Ordner
heard-page-holds = die Seite enthält { $width } × { $height } von { $all-width } × { $all-height } Pixeln, da sie unter 3 MB bleiben soll
heard-page-lens = die Seite hat ein rundes Objektiv ohne Fehler und Korn

# Recipes, lenses, scales.
heard-lens-file = dieses Objektiv ist nicht verwendbar — { $why } — ein Objektiv hat name, focal_mm, f_numbers und kann blades und nearest_m haben
heard-recipe-read = das Rezept ist nicht lesbar — { $why }
heard-recipe-parse = dieses Rezept ist nicht verwendbar — { $why } — machen Sie eines mit „Bearbeitung kopieren“, oder schreiben Sie die Datei neben einem Foto neu
heard-no-scale = { $name } ist kein Maßstab der Tiefe: deep oder lytro
heard-no-trainer = das Trainingsprogramm fehlt — es ist ein eigenes Programm — bauen Sie es mit `cargo build --release --package plenoscope-train` und legen Sie plenoscope-train neben plenoscope
heard-trainer-start = das Trainingsprogramm startet nicht — { $why }

# What files say of themselves.
heard-hci-grid = parameters.cfg fehlt, daher sagt die Zahl der Ansichten das Raster
heard-disparity-left-out = die Disparität bleibt weg — { $why }
heard-disparity-of-view = die Disparität bleibt weg — sie gehört zu Ansicht (v { $v }, u { $u })
heard-quilt-views = { $number } der { $count } Ansichten des Quilts werden verwendet, in gleichen Abständen
heard-camera-left-out = die Kamera bleibt weg — ihre Zahlen sind die keiner Kamera
heard-encoder-failed = der Encoder ist gescheitert
heard-film-cut-off = der Film ist abgeschnitten — verwendet wird, was vor seinem Ende liegt
heard-harmonics-left-out = Kugelfunktionen über Grad { $degree } sind weggelassen
heard-laid-out = die Ansichten wurden neu angeordnet, da sie so besser zusammenpassen
heard-depths-left-out = die Strahltiefen bleiben weg — { $why }
heard-table-left-out = die Tiefentabelle bleibt weg — { $why }
heard-original-left-out = das durchgehend scharfe Original bleibt weg — { $why }
heard-profile-unusable = das Farbprofil ist nicht verwendbar, daher gelten die Farben als sRGB
heard-profile-unreadable = das Farbprofil ist nicht lesbar, daher gelten die Farben als sRGB
