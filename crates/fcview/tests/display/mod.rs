//! A user at a display of its own: starts the viewer, presses keys, moves the mouse, drops files and looks.

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConfigureWindowAux,
    ConnectionExt as _, CreateWindowAux, EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT,
    KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, MapState, PropMode, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// How long anything may take on a busy machine before it counts as not happening.
const PATIENCE: Duration = Duration::from_secs(60);

/// The keys without a letter, by their number in X.
pub(crate) const ESCAPE: u32 = 0xFF1B;
pub(crate) const ENTER: u32 = 0xFF0D;
pub(crate) const HOME: u32 = 0xFF50;
pub(crate) const CONTROL: u32 = 0xFFE3;

/// The colour of panels.
pub(crate) const PANEL: [u8; 3] = [27; 3];

/// A virtual X display.
pub(crate) struct Display {
    server: Child,
    name: String,
}

/// A running viewer and a connection to its display.
pub(crate) struct Viewer {
    pub(crate) child: Child,
    x: RustConnection,
    root: Window,
    pub(crate) window: Window,
    /// The number of the extension that fakes input.
    faker: u8,
}

/// What is on the screen.
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) rgb: Vec<[u8; 3]>,
}

impl Display {
    /// Starts a server; a test of the window that passes without one would prove nothing.
    pub(crate) fn start() -> Display {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| panic!("this test needs Xvfb (Debian's package xvfb): {error}"));
        let mut number = String::new();
        let said = BufReader::new(server.stdout.as_mut().unwrap()).read_line(&mut number);
        assert!(said.unwrap() > 0, "Xvfb did not start");
        Display { server, name: format!(":{}", number.trim()) }
    }

    /// Ends the server, as when somebody logs out.
    pub(crate) fn stop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }

    /// Starts the viewer in a folder and waits for its window.
    pub(crate) fn view(&self, folder: &Path, words: &str) -> Viewer {
        self.view_with(folder, words, &[])
    }

    /// The same with variables of the environment.
    pub(crate) fn view_with(&self, folder: &Path, words: &str, variables: &[(&str, &str)]) -> Viewer {
        let child = self.spawn(folder, words, variables);
        let (x, screen) = x11rb::connect(Some(&self.name)).unwrap();
        let root = x.setup().roots[screen].root;
        let faker = x.query_extension(b"XTEST").unwrap().reply().unwrap();
        assert!(faker.present, "the display cannot fake input");
        let mut viewer = Viewer { child, x, root, window: 0, faker: faker.major_opcode };
        viewer.window = wait_for("the window", || viewer.find());
        viewer.x.set_input_focus(InputFocus::PARENT, viewer.window, x11rb::CURRENT_TIME).unwrap();
        viewer
    }

    /// Starts the viewer.
    pub(crate) fn spawn(&self, folder: &Path, words: &str, variables: &[(&str, &str)]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fcview"));
        command.current_dir(folder).args(words.split_whitespace()).env("DISPLAY", &self.name);
        command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.env_remove("WINIT_X11_SCALE_FACTOR").envs(variables.iter().copied());
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Viewer {
    /// The viewer's window, once it is on the screen.
    fn find(&self) -> Option<Window> {
        let windows = self.x.query_tree(self.root).ok()?.reply().ok()?.children;
        windows.into_iter().find(|window| {
            let viewable = self.x.get_window_attributes(*window).ok().and_then(|cookie| cookie.reply().ok());
            viewable.is_some_and(|found| found.map_state == MapState::VIEWABLE)
                && self.title_of(*window).ends_with("facetree")
        })
    }

    fn title_of(&self, window: Window) -> String {
        let property = self.x.get_property(false, window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 100);
        let value = property.ok().and_then(|cookie| cookie.reply().ok()).map(|reply| reply.value);
        String::from_utf8_lossy(&value.unwrap_or_default()).into_owned()
    }

    /// What stands above the window.
    pub(crate) fn title(&self) -> String {
        self.title_of(self.window)
    }

    /// The bytes of a property of the window.
    pub(crate) fn property(&self, name: &str) -> usize {
        let atom = self.atom(name);
        let property = self.x.get_property(false, self.window, atom, AtomEnum::ANY, 0, 1 << 20).unwrap();
        property.reply().unwrap().value.len()
    }

    /// Waits until the viewer is done and returns how, with what it said.
    pub(crate) fn end(mut self) -> (ExitStatus, String) {
        end(&mut self.child)
    }

    /// Fails if the viewer does not run any more, with what it said.
    pub(crate) fn runs(&mut self, what: &str) {
        if let Some(status) = self.child.try_wait().unwrap() {
            panic!("{what}: {status}: {}", end(&mut self.child).1);
        }
    }

    /// The window's picture.
    pub(crate) fn picture(&self) -> Picture {
        let size = self.x.get_geometry(self.window).unwrap().reply().unwrap();
        let image = self
            .x
            .get_image(ImageFormat::Z_PIXMAP, self.window, 0, 0, size.width, size.height, !0)
            .unwrap()
            .reply()
            .unwrap();
        let rgb = image.data.chunks_exact(4).map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect();
        Picture { width: usize::from(size.width), height: usize::from(size.height), rgb }
    }

    /// Waits until a picture is as it should be; a failure leaves the last one where it says.
    pub(crate) fn see(&self, what: &str, good: impl Fn(&Picture) -> bool) -> Picture {
        let start = Instant::now();
        loop {
            let picture = self.picture();
            if good(&picture) {
                return picture;
            }
            if start.elapsed() > PATIENCE {
                panic!("{what} was not seen; the window is in {}", picture.save().display());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Waits until the window shows a model.
    pub(crate) fn see_model(&self) {
        self.see("a model", |picture| picture.bright() > 50);
    }

    /// Presses and releases keys, each for a moment: letters by themselves, others by their number in X.
    pub(crate) fn press(&self, symbol: u32) {
        self.key(symbol, true);
        std::thread::sleep(Duration::from_millis(20));
        self.key(symbol, false);
        std::thread::sleep(Duration::from_millis(20));
    }

    /// Types a text of small letters, digits and dots.
    pub(crate) fn write(&self, text: &str) {
        for letter in text.chars() {
            self.press(u32::from(letter));
        }
    }

    /// A key goes down or up.
    pub(crate) fn key(&self, symbol: u32, down: bool) {
        let setup = self.x.setup();
        let (low, high) = (setup.min_keycode, setup.max_keycode);
        let map = self.x.get_keyboard_mapping(low, high - low + 1).unwrap().reply().unwrap();
        let place = map
            .keysyms
            .chunks(usize::from(map.keysyms_per_keycode))
            .position(|symbols| symbols.first() == Some(&symbol))
            .unwrap_or_else(|| panic!("the display's keyboard lacks {symbol:#x}"));
        let code = low + u8::try_from(place).unwrap();
        self.fake(if down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT }, code, [0, 0]);
    }

    /// Drags with a button, 1 the left one, in a few steps.
    pub(crate) fn drag(&self, button: u8, from: [i16; 2], to: [i16; 2]) {
        self.fake(MOTION_NOTIFY_EVENT, 0, from);
        std::thread::sleep(Duration::from_millis(50));
        self.fake(BUTTON_PRESS_EVENT, button, [0, 0]);
        for step in 1..=5 {
            let part = |k: usize| from[k] + (to[k] - from[k]) * step / 5;
            self.fake(MOTION_NOTIFY_EVENT, 0, [part(0), part(1)]);
            std::thread::sleep(Duration::from_millis(30));
        }
        self.fake(BUTTON_RELEASE_EVENT, button, [0, 0]);
        std::thread::sleep(Duration::from_millis(100));
    }

    /// Clicks twice with the left button.
    pub(crate) fn double_click(&self, at: [i16; 2]) {
        self.fake(MOTION_NOTIFY_EVENT, 0, at);
        std::thread::sleep(Duration::from_millis(50));
        for _ in 0..2 {
            self.fake(BUTTON_PRESS_EVENT, 1, [0, 0]);
            self.fake(BUTTON_RELEASE_EVENT, 1, [0, 0]);
        }
        std::thread::sleep(Duration::from_millis(100));
    }

    /// Turns the wheel: up, away from the user, or down.
    pub(crate) fn wheel(&self, at: [i16; 2], notches: i32) {
        self.fake(MOTION_NOTIFY_EVENT, 0, at);
        std::thread::sleep(Duration::from_millis(50));
        for _ in 0..notches.abs() {
            let button = if notches > 0 { 4 } else { 5 };
            self.fake(BUTTON_PRESS_EVENT, button, [0, 0]);
            self.fake(BUTTON_RELEASE_EVENT, button, [0, 0]);
        }
        std::thread::sleep(Duration::from_millis(100));
    }

    /// Gives the window another size.
    pub(crate) fn resize(&self, width: u32, height: u32) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.x.configure_window(self.window, &size).unwrap();
        self.x.flush().unwrap();
    }

    /// Takes the window off the screen or puts it back.
    pub(crate) fn show(&self, shown: bool) {
        if shown {
            self.x.map_window(self.window).unwrap();
            self.x.set_input_focus(InputFocus::PARENT, self.window, x11rb::CURRENT_TIME).unwrap();
        } else {
            self.x.unmap_window(self.window).unwrap();
        }
        self.x.flush().unwrap();
    }

    /// Drops a file on the window, by the protocol that file managers speak (XDND).
    pub(crate) fn drop_file(&self, path: &Path) {
        let ours = self.x.generate_id().unwrap();
        let (root, none) = (self.root, CreateWindowAux::new());
        self.x.create_window(0, ours, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &none).unwrap();
        let [selection, list] = [self.atom("XdndSelection"), self.atom("text/uri-list")];
        self.x.set_selection_owner(ours, selection, x11rb::CURRENT_TIME).unwrap();
        let send = |name: &str, data: [u32; 5]| {
            let message = ClientMessageEvent::new(32, self.window, self.atom(name), data);
            self.x.send_event(false, self.window, EventMask::NO_EVENT, message).unwrap();
            self.x.flush().unwrap();
        };
        send("XdndEnter", [ours, 5 << 24, list, 0, 0]);
        send("XdndPosition", [ours, 0, (300 << 16) | 300, 0, self.atom("XdndActionCopy")]);
        let request =
            wait_for("a question for the dropped file", || match self.x.poll_for_event().unwrap() {
                Some(Event::SelectionRequest(request)) => Some(request),
                Some(_) => None,
                None => {
                    std::thread::sleep(Duration::from_millis(20));
                    None
                }
            });
        let text = format!("file://{}\r\n", path.display());
        self.x
            .change_property8(PropMode::REPLACE, request.requestor, request.property, list, text.as_bytes())
            .unwrap();
        let answer = SelectionNotifyEvent {
            response_type: x11rb::protocol::xproto::SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time: request.time,
            requestor: request.requestor,
            selection: request.selection,
            target: request.target,
            property: request.property,
        };
        self.x.send_event(false, request.requestor, EventMask::NO_EVENT, answer).unwrap();
        self.x.flush().unwrap();
        std::thread::sleep(Duration::from_millis(200));
        send("XdndDrop", [ours, 0, 0, 0, 0]);
    }

    fn atom(&self, name: &str) -> u32 {
        self.x.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    /// XTestFakeInput, written out: x11rb has it behind a feature that winit does not ask for, and tests and programs
    /// would each compile winit.
    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        let mut request = [0; 36];
        request[..6].copy_from_slice(&[self.faker, 2, 9, 0, kind, detail]);
        request[24..26].copy_from_slice(&x.to_ne_bytes());
        request[26..28].copy_from_slice(&y.to_ne_bytes());
        let parts = [std::io::IoSlice::new(&request)];
        self.x.send_request_without_reply(&parts, Vec::new()).unwrap();
        self.x.flush().unwrap();
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Picture {
    /// The number of pixels of some kind right of the panel's place.
    pub(crate) fn count(&self, kind: impl Fn(&[u8; 3]) -> bool) -> usize {
        let panel = if self.width > 400 { 300 } else { 0 };
        let places = self.rgb.iter().enumerate().filter(|(place, _)| place % self.width >= panel);
        places.filter(|(_, rgb)| kind(rgb)).count()
    }

    /// The number of pixels brighter than the background ever is.
    pub(crate) fn bright(&self) -> usize {
        self.count(|rgb| rgb[0] > 150)
    }

    /// The size of the panel: the last row and column of its colour.
    pub(crate) fn panel(&self) -> [usize; 2] {
        let mut size = [0, 0];
        for (place, rgb) in self.rgb.iter().enumerate() {
            if *rgb == PANEL {
                size = [size[0].max(place % self.width), size[1].max(place / self.width)];
            }
        }
        size
    }

    /// Writes the picture where tests leave things to look at.
    pub(crate) fn save(&self) -> PathBuf {
        let thread = std::thread::current();
        let name = thread.name().unwrap_or("window").replace("::", "-");
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        let file = std::fs::File::create(&path).unwrap();
        let mut encoder = png::Encoder::new(file, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header().unwrap().write_image_data(self.rgb.as_flattened()).unwrap();
        path
    }
}

/// Waits until there is an answer.
pub(crate) fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(start.elapsed() < PATIENCE, "{what} did not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until a viewer is done and returns how, with what it said.
pub(crate) fn end(child: &mut Child) -> (ExitStatus, String) {
    let status = wait_for("the viewer's end", || child.try_wait().unwrap());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    (status, said)
}
