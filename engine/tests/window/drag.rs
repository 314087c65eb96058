//! Another client of the display, from which files are dragged.

use std::time::Duration;

use super::session::wait;

/// Drags a file from a window of another client onto a window, and drops it there: the XDND protocol, version 5.
pub(crate) fn drop_file(display: &str, window: u32, file: &std::path::Path) {
    use x11rb::connection::Connection as _;
    use x11rb::protocol::Event;
    use x11rb::protocol::xproto::{
        ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode, SELECTION_NOTIFY_EVENT,
        SelectionNotifyEvent, WindowClass,
    };
    use x11rb::wrapper::ConnectionExt as _;

    let (client, screen) = x11rb::connect(Some(display)).unwrap();
    let atom = |name: &str| client.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let root = client.setup().roots[screen].root;
    let source = client.generate_id().unwrap();
    let nothing = CreateWindowAux::new();
    client.create_window(0, source, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &nothing).unwrap();
    let (selection, list, status) = (atom("XdndSelection"), atom("text/uri-list"), atom("XdndStatus"));
    client.set_selection_owner(source, selection, 0_u32).unwrap();
    let send = |kind: &str, data: [u32; 5]| {
        let event = ClientMessageEvent::new(32, window, atom(kind), data);
        client.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        client.flush().unwrap();
    };
    send("XdndEnter", [source, 5 << 24, list, 0, 0]);
    send("XdndPosition", [source, 0, 50 << 16 | 50, 0, atom("XdndActionCopy")]);
    let (mut accepted, mut handed) = (false, false);
    wait("a drop that is accepted", || {
        while let Some(event) = client.poll_for_event().unwrap() {
            match event {
                Event::ClientMessage(message) if message.type_ == status => accepted = true,
                Event::SelectionRequest(request) => {
                    let text = format!("file://{}\r\n", file.display());
                    let property = if request.property == 0 { request.target } else { request.property };
                    let (requestor, target) = (request.requestor, request.target);
                    client.change_property8(PropMode::REPLACE, requestor, property, target, text.as_bytes()).unwrap();
                    let notify = SelectionNotifyEvent {
                        response_type: SELECTION_NOTIFY_EVENT,
                        sequence: 0,
                        time: request.time,
                        requestor,
                        selection: request.selection,
                        target,
                        property,
                    };
                    client.send_event(false, requestor, EventMask::NO_EVENT, notify).unwrap();
                    client.flush().unwrap();
                    handed = true;
                }
                _ => {}
            }
        }
        accepted && handed
    });
    send("XdndDrop", [source, 0, 0, 0, 0]);
    std::thread::sleep(Duration::from_millis(300));
}
